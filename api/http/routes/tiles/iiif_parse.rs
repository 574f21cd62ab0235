//! Parses requests of the IIIF Image API 3.0: region, size, rotation, quality and format (section 4 of the API).

use super::grid::tile_format;
use crate::http::problem::{Kind, Problem};
use crate::service::pictures::spec::{Grid, PictureSpec};
use strahl::film::{Adjustment, FileFormat, Region, Tone};

/// The parts of an image request's path.
#[derive(Debug, Clone, Copy)]
pub(crate) struct ImageRequest<'a> {
    pub(crate) region: &'a str,
    pub(crate) size: &'a str,
    pub(crate) rotation: &'a str,
    /// `quality.format`.
    pub(crate) file: &'a str,
}

/// A parsed request, and its canonical form.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct Understood {
    pub(crate) spec: PictureSpec,
    /// `region/size/rotation/quality.format`.
    pub(crate) canonical: String,
}

/// Parses a request for an image of some size. An answer has at most `max_area` pixels.
pub(crate) fn understand(asked: ImageRequest<'_>, image: [u32; 2], max_area: u64) -> Result<Understood, Problem> {
    let from = region(asked.region, image)?;
    let size = size(asked.size, from, max_area)?;
    let (mirrored, quarters) = rotation(asked.rotation)?;
    let (tone, quality, format, ending) = quality_and_format(asked.file)?;
    let (grid, shown) = grid(from, size, image);
    let spec =
        PictureSpec { grid, adjustment: Adjustment { mirrored, quarters, tone }, ..PictureSpec::plain(shown, format) };

    let Region { x, y, width, height } = from;
    let whole = from == Region::whole(image[0], image[1]);
    let region = if whole { "full".to_owned() } else { format!("{x},{y},{width},{height}") };
    let size = match size {
        _ if size == largest([width, height], max_area) => "max".to_owned(),
        [w, h] => format!("{}{w},{h}", if w > width || h > height { "^" } else { "" }),
    };
    let rotation = format!("{}{}", if mirrored { "!" } else { "" }, u32::from(quarters) * 90);
    Ok(Understood { spec, canonical: format!("{region}/{size}/{rotation}/{quality}.{ending}") })
}

fn bad(what: &str, given: &str, expected: &str) -> Problem {
    Problem::new(Kind::BadIiifRequest, format!("{given} is no {what}: expected {expected}"))
}

/// Parses the region, and clips it to the image. A region outside of the image is an error.
fn region(text: &str, [width, height]: [u32; 2]) -> Result<Region, Problem> {
    let wrong =
        || bad("region of this image", text, "full, square, x,y,w,h or pct:x,y,w,h with some of it in the image");
    let [x, y, w, h] = match text {
        "full" => return Ok(Region::whole(width, height)),
        "square" => {
            let side = width.min(height);
            return Ok(Region { x: (width - side) / 2, y: (height - side) / 2, width: side, height: side });
        }
        _ => match text.strip_prefix("pct:") {
            Some(percentages) => {
                let [x, y, w, h] = list(percentages).ok_or_else(wrong)?.map(decimal);
                let of = |percent: Option<f64>, length: u32| {
                    percent.filter(|p| *p <= 1e6).map(|p| (p / 100.0 * f64::from(length)).round() as u64)
                };
                [of(x, width), of(y, height), of(w, width), of(h, height)]
            }
            None => list(text).ok_or_else(wrong)?.map(|number| number.parse::<u64>().ok()),
        },
    };
    let cut = |start: Option<u64>, length: Option<u64>, end: u32| {
        let (start, length) = (start?, length?);
        let left = u64::from(end).checked_sub(start)?.min(length);
        // Both are below the image's length now.
        Some((start as u32, left as u32)).filter(|_| left > 0)
    };
    let ((x, width), (y, height)) = (cut(x, w, width).ok_or_else(wrong)?, cut(y, h, height).ok_or_else(wrong)?);
    Ok(Region { x, y, width, height })
}

fn list<const N: usize>(text: &str) -> Option<[&str; N]> {
    text.split(',').collect::<Vec<_>>().try_into().ok()
}

/// Parses a decimal number: digits, with or without a point and more digits.
fn decimal(text: &str) -> Option<f64> {
    let plain = text.bytes().all(|byte| byte.is_ascii_digit() || byte == b'.');
    if plain { text.parse().ok() } else { None }
}

/// The largest size of an answer with the same shape.
fn largest([width, height]: [u32; 2], max_area: u64) -> [u32; 2] {
    let area = u64::from(width) * u64::from(height);
    if area <= max_area {
        return [width, height];
    }
    let scale = (max_area as f64 / area as f64).sqrt();
    [width, height].map(|length| ((f64::from(length) * scale).floor() as u32).max(1))
}

fn size(text: &str, region: Region, max_area: u64) -> Result<[u32; 2], Problem> {
    let wrong = || bad("size", text, "max, w,h w, ,h pct:n or !w,h, and ^ before it to enlarge");
    let (enlarges, form) = text.strip_prefix('^').map_or((false, text), |form| (true, form));
    let (width, height) = (f64::from(region.width), f64::from(region.height));
    let number = |text: &str| text.parse::<u32>().ok().filter(|number| *number > 0).ok_or_else(wrong);
    let rounded = |length: f64| if length < 4e9 { Ok((length.round() as u32).max(1)) } else { Err(wrong()) };
    let [w, h] = if form == "max" {
        if enlarges {
            let scale = (max_area as f64 / (width * height)).sqrt();
            [rounded((width * scale).floor())?, rounded((height * scale).floor())?]
        } else {
            largest([region.width, region.height], max_area)
        }
    } else if let Some(percent) = form.strip_prefix("pct:") {
        let scale = decimal(percent).filter(|percent| *percent > 0.0).ok_or_else(wrong)? / 100.0;
        [rounded(width * scale)?, rounded(height * scale)?]
    } else if let Some(within) = form.strip_prefix('!') {
        let [w, h] = list(within).ok_or_else(wrong)?;
        let scale = (f64::from(number(w)?) / width).min(f64::from(number(h)?) / height);
        // Section 4.2 lets a box larger than the region hold the region as it is; the validator wants it refused, and so
        // does what follows.
        [rounded(width * scale)?, rounded(height * scale)?]
    } else {
        match list(form).ok_or_else(wrong)? {
            ["", ""] => return Err(wrong()),
            [w, ""] => [number(w)?, rounded(height * f64::from(number(w)?) / width)?],
            ["", h] => [rounded(width * f64::from(number(h)?) / height)?, number(h)?],
            [w, h] => [number(w)?, number(h)?],
        }
    };
    if !enlarges && (w > region.width || h > region.height) {
        return Err(bad("size", text, "one no larger than the region, or ^ before it"));
    }
    if u64::from(w) * u64::from(h) > max_area {
        let expected = format!("at most {max_area} pixels (maxArea in info.json)");
        return Err(bad("size for one answer", text, &expected));
    }
    Ok([w, h])
}

/// Parses whether the image is mirrored, and the quarter turns after that.
fn rotation(text: &str) -> Result<(bool, u8), Problem> {
    let (mirrored, degrees) = text.strip_prefix('!').map_or((false, text), |degrees| (true, degrees));
    let degrees = decimal(degrees);
    let quarters = [0.0, 90.0, 180.0, 270.0, 360.0].iter().position(|known| Some(*known) == degrees);
    let wrong = || bad("rotation", text, "0, 90, 180, 270 or 360, and ! before it to mirror");
    quarters.map(|quarters| (mirrored, quarters as u8 % 4)).ok_or_else(wrong)
}

fn quality_and_format(file: &str) -> Result<(Tone, &str, FileFormat, &str), Problem> {
    let wrong = || bad("quality and format", file, "default, color, gray or bitonal, and .jpg, .png or .webp");
    let (quality, ending) = file.split_once('.').ok_or_else(wrong)?;
    let tone = match quality {
        "default" | "color" => Tone::Color,
        "gray" => Tone::Gray,
        "bitonal" => Tone::Bitonal,
        _ => return Err(wrong()),
    };
    // The canonical name of the color that it has anyway.
    let quality = if quality == "color" { "default" } else { quality };
    let format = tile_format(ending).filter(|_| ending != "jpeg").ok_or_else(wrong)?;
    Ok((tone, quality, format, ending))
}

/// The grid of pixels for a region in some size. If it fits a level of the image, the answer is a crop of that level.
fn grid(region: Region, [w, h]: [u32; 2], image: [u32; 2]) -> (Grid, Option<Region>) {
    let Region { x, y, width, height } = region;
    let down = |level: u32, start: u32, length: u32, end: u32, wanted: u32| {
        let step = 1_u64 << level;
        let (start, length, end) = (u64::from(start), u64::from(length), u64::from(end));
        let fits = length.is_multiple_of(step) || start + length == end;
        start.is_multiple_of(step) && fits && length.div_ceil(step) == u64::from(wanted)
    };
    let up = |level: u32, length: u32, wanted: u32| u64::from(length) << level == u64::from(wanted);
    for level in 0..32 {
        if down(level, x, width, image[0], w) && down(level, y, height, image[1], h) {
            let region = Region { x: x >> level, y: y >> level, width: w, height: h };
            let whole = x == 0 && y == 0 && [width, height] == image;
            return (Grid::Level(level as i32), Some(region).filter(|_| !whole));
        }
        if up(level, width, w) && up(level, height, h) {
            let whole = [width, height] == image;
            let enlarged = x.checked_shl(level).zip(y.checked_shl(level));
            if let Some((x, y)) = enlarged.filter(|(left, top)| left >> level == x && top >> level == y) {
                let region = Region { x, y, width: w, height: h };
                return (Grid::Level(-(level as i32)), Some(region).filter(|_| !whole));
            }
        }
    }
    (Grid::Part(region, [w, h]), None)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn of(path: &str) -> Result<Understood, Problem> {
        let [region, size, rotation, file] = path.split('/').collect::<Vec<_>>().try_into().unwrap();
        understand(ImageRequest { region, size, rotation, file }, [1_000, 600], 1_000_000)
    }

    fn shown(path: &str) -> (Grid, Option<Region>) {
        let Understood { spec, .. } = of(path).unwrap();
        (spec.grid, spec.region)
    }

    fn rectangle(x: u32, y: u32, width: u32, height: u32) -> Region {
        Region { x, y, width, height }
    }

    #[test]
    fn what_fits_a_level_is_a_crop_of_it() {
        assert_eq!(shown("full/max/0/default.png"), (Grid::Level(0), None));
        assert_eq!(shown("full/500,/0/default.png"), (Grid::Level(1), None));
        assert_eq!(shown("full/,38/0/default.png"), (Grid::Level(4), None));
        assert_eq!(shown("full/,39/0/default.png").0, Grid::Part(rectangle(0, 0, 1_000, 600), [65, 39]));
        assert_eq!(shown("full/63,38/0/default.png"), (Grid::Level(4), None));
        // As OpenSeadragon asks for tiles: the last ones are as wide as the level, rounded up.
        assert_eq!(shown("512,512,488,88/244,44/0/default.png"), (Grid::Level(1), Some(rectangle(256, 256, 244, 44))));
        assert_eq!(shown("512,0,488,512/61,64/0/default.png"), (Grid::Level(3), Some(rectangle(64, 0, 61, 64))));
        assert_eq!(shown("10,20,30,40/^120,160/0/default.png"), (Grid::Level(-2), Some(rectangle(40, 80, 120, 160))));
        assert_eq!(shown("10,20,30,40/15,20/0/default.png"), (Grid::Level(1), Some(rectangle(5, 10, 15, 20))));
        assert_eq!(shown("11,20,30,40/15,20/0/default.png").0, Grid::Part(rectangle(11, 20, 30, 40), [15, 20]));
        assert_eq!(shown("10,20,30,40/7,/0/default.png").0, Grid::Part(rectangle(10, 20, 30, 40), [7, 9]));
    }

    #[test]
    fn every_form_has_its_canonical_one() {
        for (path, canonical) in [
            ("full/max/0/color.jpg", "full/max/0/default.jpg"),
            ("0,0,1000,600/1000,/0/default.png", "full/max/0/default.png"),
            ("0,0,5000,5000/max/!90/gray.webp", "full/max/!90/gray.webp"),
            ("full/max/360/default.png", "full/max/0/default.png"),
            ("full/max/!0.0/default.png", "full/max/!0/default.png"),
            ("full/max/270.00/default.png", "full/max/270/default.png"),
            ("square/pct:50/0/default.png", "200,0,600,600/300,300/0/default.png"),
            ("pct:10,10,20.5,50/!100,100/0/default.png", "100,60,205,300/68,100/0/default.png"),
            ("square/^800,/0/default.png", "200,0,600,600/^800,800/0/default.png"),
            ("full/^!1200,1200/0/default.png", "full/^1200,720/0/default.png"),
            ("full/^1000,600/0/default.png", "full/max/0/default.png"),
            ("0,0,100,100/^max/0/bitonal.png", "0,0,100,100/^1000,1000/0/bitonal.png"),
        ] {
            assert_eq!(of(path).map(|understood| understood.canonical).ok().as_deref(), Some(canonical), "{path}");
        }
    }

    #[test]
    fn what_makes_no_sense_is_refused() {
        for path in [
            "1000,0,10,10/max/0/default.png",
            "0,0,0,10/max/0/default.png",
            "0,0,10/max/0/default.png",
            "-1,0,10,10/max/0/default.png",
            "pct:0,0,nan,10/max/0/default.png",
            "full/1001,/0/default.png",
            "full/0,/0/default.png",
            "full/,/0/default.png",
            "full/pct:0/0/default.png",
            "full/pct:101/0/default.png",
            "full/!9000,9000/0/default.png",
            "full/^2000,2000/0/default.png",
            "full/^99999999999,1/0/default.png",
            "full/max/45/default.png",
            "full/max/90.5/default.png",
            "full/max/360.1/default.png",
            "full/max/450/default.png",
            "full/max/-90/default.png",
            "full/max/+90/default.png",
            "full/max/9e1/default.png",
            "full/max/nan/default.png",
            "full/max/./default.png",
            "full/max//default.png",
            "full/max/!/default.png",
            "full/max/0/native.png",
            "full/max/0/default.exr",
            "full/max/0/default",
        ] {
            assert!(of(path).is_err(), "{path}");
        }
    }
}
