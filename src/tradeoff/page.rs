//! A trade-off as a self-contained HTML page: no network, no script, light and dark.

use super::advice::{figure, percent};
use super::findings::{Cost, Finer, HOW_TIMES_ARE_MEASURED, Source, Tradeoff};
use super::plot;
use super::sweep::{Point, brief};
use crate::film::encode::png_of;
use crate::metrics::{Difference, Image8};
use crate::scene::description::Precision;
use std::fmt::Write;

/// Small pictures of one point.
#[derive(Debug, Clone)]
pub struct Thumbnails {
    /// The picture.
    pub picture: Image8,
    /// How it differs from the same samples with the reference's recursion.
    pub truncation: Option<Image8>,
    /// How it differs from the reference with 64 samples.
    pub total: Option<Image8>,
}

/// Pixels across a small picture.
const THUMBNAIL: usize = 144;
/// Differences are multiplied by this to make them visible.
const MAGNIFIED: u16 = 16;

impl Image8 {
    /// A smaller copy: the mean of the codes in each square.
    #[must_use]
    pub fn thumbnail(&self) -> Self {
        self.reduced(|square| {
            let count = square.len() as u32;
            std::array::from_fn(|c| (square.iter().map(|p| u32::from(p[c])).sum::<u32>() / count) as u8)
        })
    }

    /// A smaller picture of the differences to another of the same size: the largest in each square, magnified.
    #[must_use]
    pub fn difference(&self, other: &Self) -> Self {
        let differ = |(a, b): (&[u8; 3], &[u8; 3])| std::array::from_fn(|c| a[c].abs_diff(b[c]));
        let pixels: Vec<[u8; 3]> = self.pixels.iter().zip(&other.pixels).map(differ).collect();
        Self { width: self.width, pixels }.reduced(|square| {
            let largest = |c: usize| square.iter().map(|p| p[c]).max().unwrap_or(0);
            std::array::from_fn(|c| (u16::from(largest(c)) * MAGNIFIED).min(255) as u8)
        })
    }

    /// One pixel for each square of them.
    fn reduced(&self, pixel: impl Fn(&[[u8; 3]]) -> [u8; 3]) -> Self {
        let edge = self.width.div_ceil(THUMBNAIL).max(1);
        let (width, height) = (self.width.div_ceil(edge), self.height().div_ceil(edge));
        let square = |i: usize| {
            let (left, top) = (i % width * edge, i / width * edge);
            let rows = (top..(top + edge).min(self.height())).map(|y| &self.pixels[y * self.width..][..self.width]);
            let square: Vec<[u8; 3]> =
                rows.flat_map(|row| &row[left..(left + edge).min(self.width)]).copied().collect();
            pixel(&square)
        };
        Self { width, pixels: (0..width * height).map(square).collect() }
    }
}

/// The whole page; `thumbnails` are those of the points, where there are any.
pub fn page(tradeoff: &Tradeoff, thumbnails: &[Option<Thumbnails>]) -> String {
    let name = escape(tradeoff.scene.as_deref().unwrap_or("a scene without a name"));
    let mut page = format!(
        "<!doctype html><html lang=\"en\"><meta charset=\"utf-8\"><meta name=\"viewport\" content=\"width=device-width\">\
         <title>What accuracy costs: {name}</title><style>{STYLE}{}</style><main><h1>What accuracy costs: {name}</h1>",
        plot::STYLE
    );
    // Writing to a String cannot fail.
    circumstances(&mut page, tradeoff);
    page.push_str("<h2>In short</h2><ul>");
    for sentence in &tradeoff.advice {
        let _ = write!(page, "<li>{}", escape(sentence));
    }
    page.push_str("</ul><h2>Error against cost</h2><p>Dots are measured: the root mean square error, and above it the largest of \
        any pixel and channel. The dashed line joins the settings that no other beats in both. Recursion: one sample in the \
        middle of each pixel, against the same samples followed as far as the reference. Both errors: against 64 samples.</p><div class=\"plots\">");
    for front in &tradeoff.fronts {
        let _ = write!(
            page,
            "<figure>{}<figcaption>{}</figcaption></figure>",
            plot::plot(&tradeoff.points, front, false),
            plot::title(front)
        );
    }
    page.push_str("</div>");
    table(&mut page, tradeoff);
    sheet(&mut page, &tradeoff.points, thumbnails);
    page.push_str("</main>\n");
    page
}

fn circumstances(page: &mut String, tradeoff: &Tradeoff) {
    let (c, r) = (&tradeoff.circumstances, &tradeoff.reference);
    let [width, height] = c.size;
    let scaled = if c.size == c.asked_size {
        String::new()
    } else {
        format!(", scaled down from {} × {} so that all of it fits the time", c.asked_size[0], c.asked_size[1])
    };
    let all = tradeoff.points.len();
    let measured = tradeoff.points.iter().filter(|p| p.time.is_some()).count();
    let _ = write!(
        page,
        "<p>{measured} of {all} settings measured on {} with strahl {}, {} thread{} and {}, in {} s of the {} s allowed, on pictures of \
         {width} × {height} pixels{scaled}. Times are {HOW_TIMES_ARE_MEASURED}.</p>",
        c.date,
        c.version,
        c.threads,
        if c.threads == 1 { "" } else { "s" },
        c.instructions,
        figure(c.took_seconds),
        figure(c.seconds),
    );
    let step = match r.finer {
        Some(Finer { min_weight, max_codes: 0 }) => {
            format!(" On the small picture of the warm-up, min_weight {} instead changes no code.", brief(min_weight))
        }
        Some(Finer { min_weight, max_codes }) => format!(
            " On the small picture of the warm-up, min_weight {} instead changes up to {max_codes} codes: the \
             reference itself is not exact.",
            brief(min_weight)
        ),
        None if r.min_weight == 0.0 => " That follows every ray.".to_owned(),
        None => " There was no time to see what following still lighter rays would change.".to_owned(),
    };
    let dropped = if r.dropped == 0 {
        String::new()
    } else {
        format!(" {} of its rays were dropped at the limit for one sample.", r.dropped)
    };
    let _ = write!(
        page,
        "<p>Errors are <em>measured</em>, in 8-bit codes, against pictures in double precision with depth {} and min_weight {}.{step}{dropped} \
         None of them is a proof. That of recursion (with rounding) and that of too few samples are kept apart.</p>",
        r.max_depth,
        brief(r.min_weight)
    );
}

fn table(page: &mut String, tradeoff: &Tradeoff) {
    page.push_str("<h2>All settings</h2><p>As they were measured, the cheap ones first. F marks those on the front of both errors against time, K its knee. Times in ms; \
        errors in codes; same: pixels without any error; FLIP is the mean over all pixels, ΔE the CIEDE2000 of the worst pixel but 5 %.</p>\
        <div class=\"wide\"><table><thead><tr><th rowspan=\"2\">settings<th rowspan=\"2\"><th colspan=\"4\">time<th rowspan=\"2\">rays\
        <th colspan=\"4\">recursion<th>samples<th colspan=\"6\">both errors<th rowspan=\"2\">proved\
        <tr><th>median<th>least<th>most<th>runs<th>largest<th>99.9 %<th>RMS<th>same<th>RMS<th>largest<th>RMS<th>same<th>PSNR<th>FLIP<th>ΔE</thead><tbody>");
    let front = tradeoff.fronts.iter().find(|f| (f.error, f.cost) == (Source::Total, Cost::Time));
    for (i, point) in tradeoff.points.iter().enumerate() {
        let knee = front.is_some_and(|f| f.knee == Some(i));
        let mark = if knee {
            "K"
        } else if front.is_some_and(|f| f.points.contains(&i)) {
            "F"
        } else {
            ""
        };
        let _ = write!(
            page,
            "<tr{}><th>{}<td>{mark}",
            if mark.is_empty() { "" } else { " class=\"best\"" },
            point.settings
        );
        row(page, point);
    }
    page.push_str("</tbody></table></div>");
}

fn row(page: &mut String, point: &Point) {
    match (&point.time, &point.rays) {
        (Some(time), Some(rays)) => {
            let [median, min, max] = [time.median_ms, time.min_ms, time.max_ms].map(figure);
            let _ = write!(
                page,
                "<td>{median}<td>{min}<td>{max}<td>{}<td title=\"camera {}, shadow {}, reflected {}, transmitted {}, gathered {}\">{}",
                time.repeats,
                rays.camera,
                rays.shadow,
                rays.reflected,
                rays.transmitted,
                rays.gathered,
                rays.total()
            );
        }
        _ => page.push_str("<td colspan=\"5\">not measured: the time was over"),
    }
    let cell = |page: &mut String, error: Option<&Difference>, of: fn(&Difference) -> String| {
        let _ = write!(page, "<td>{}", error.map_or_else(|| "–".to_owned(), of));
    };
    let identical = |e: &Difference| percent(e.codes.identical);
    let truncation = point.measured.truncation.as_ref();
    cell(page, truncation, |e| figure(e.codes.error.max));
    cell(page, truncation, |e| figure(e.codes.error.p999));
    cell(page, truncation, |e| figure(e.rms_codes));
    cell(page, truncation, identical);
    cell(page, point.measured.sampling.as_ref(), |e| figure(e.rms_codes));
    let total = point.measured.total.as_ref();
    cell(page, total, |e| figure(e.codes.error.max));
    cell(page, total, |e| figure(e.rms_codes));
    cell(page, total, identical);
    cell(page, total, |e| e.codes.psnr.map_or_else(|| "∞".into(), figure));
    cell(page, total, |e| figure(e.flip.mean));
    cell(page, total, |e| figure(e.ciede2000.p95));
    let _ = write!(page, "<td>{}", point.proved_codes.map_or_else(|| "–".into(), |codes| format!("≤ {codes}")));
}

fn sheet(page: &mut String, points: &[Point], thumbnails: &[Option<Thumbnails>]) {
    let _ = write!(
        page,
        "<h2>Pictures</h2><p>Each picture, and its differences, {MAGNIFIED} times as bright as they are and the largest of each square: \
         to the same samples with the reference's recursion, and to 64 samples.</p><div class=\"sheet\">"
    );
    for (point, small) in points.iter().zip(thumbnails) {
        let Some(small) = small else { continue };
        page.push_str("<figure>");
        let named = [
            (Some(&small.picture), "picture"),
            (small.truncation.as_ref(), "difference by recursion"),
            (small.total.as_ref(), "all difference"),
        ];
        for (picture, name) in named {
            if let Some(picture) = picture {
                let (width, height) = (picture.width, picture.height());
                let png =
                    data_encoding::BASE64.encode(&png_of(width as u32, height as u32, picture.pixels.as_flattened()));
                let _ = write!(
                    page,
                    "<img width=\"{width}\" height=\"{height}\" alt=\"{name}\" src=\"data:image/png;base64,{png}\">"
                );
            }
        }
        let bold = if point.settings.precision == Precision::Double { "double" } else { "single" };
        let _ = write!(page, "<figcaption class=\"{bold}\">{}</figcaption></figure>", point.settings);
    }
    page.push_str("</div>");
}

const STYLE: &str = "\
:root{color-scheme:light dark}body{font:15px/1.5 system-ui,sans-serif;margin:0;color:#222;background:#fafafa}\
main{max-width:1320px;margin:1.5em auto;padding:0 1em}h1{font-size:1.7em}h2{margin-top:1.6em}figure{margin:0}\
.plots{display:grid;grid-template-columns:repeat(auto-fit,minmax(min(100%,480px),1fr));gap:1em}figcaption{color:#555;font-size:.85em}\
.plots svg{width:100%;height:auto;border:1px solid #ddd}.wide{overflow-x:auto}\
table{border-collapse:collapse;font-size:.82em;font-variant-numeric:tabular-nums;background:#fff}\
td,th{border:1px solid #ddd;padding:.2em .5em;text-align:right;white-space:nowrap}th{background:#eef1f6;font-weight:600;text-align:center}\
tbody th{text-align:left;font-weight:400;background:none}.best{background:#e8f4e8}\
.sheet{display:grid;grid-template-columns:repeat(auto-fill,minmax(min(100%,400px),1fr));gap:1em}.sheet img{width:calc(33.3% - 3px);height:auto;margin-right:3px}\
@media(prefers-color-scheme:dark){body{color:#ddd;background:#15171a}table{background:#1b1d21}td,th,.plots svg{border-color:#3a3d44}\
thead th{background:#262a31}.best{background:#1f3324}figcaption{color:#aaa}}";

fn escape(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn small_pictures_keep_single_wrong_pixels() {
        let (width, height) = (3 * THUMBNAIL + 1, 5);
        let black = Image8 { width, pixels: vec![[0; 3]; width * height] };
        let mut one = black.clone();
        one.pixels[2 * width + 7] = [0, 2, 200];
        let small = one.difference(&black);
        assert_eq!((small.width, small.height()), (109, 2));
        assert_eq!(small.pixels[1], [0, 32, 255]);
        assert_eq!(small.pixels.iter().filter(|p| **p != [0; 3]).count(), 1);
        let grey = Image8 { width, pixels: vec![[9; 3]; width * height] };
        assert!(grey.thumbnail().pixels.iter().all(|p| *p == [9; 3]));
    }

    #[test]
    fn names_are_no_markup() {
        assert_eq!(escape("<a b=\"&\">"), "&lt;a b=&quot;&amp;&quot;&gt;");
    }
}
