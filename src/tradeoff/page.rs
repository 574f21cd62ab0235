//! A trade-off as a self-contained HTML page: no network, no script, light and dark.

use super::advice::{figure, percent};
use super::answer::{duration, in_short};
use super::choices::{Choice, Choices, NO_ANTIALIASING};
use super::findings::{Cost, Finer, HOW_TIMES_ARE_MEASURED, Reference, Source, Tradeoff};
use super::sweep::{Errors, Point, brief};
use super::{choice_plot, plot};
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
/// Pixels across one of the three pictures at the top, on a screen of two pixels for each of CSS.
const LARGE: usize = 800;
/// Differences are multiplied by this to make them visible.
const MAGNIFIED: u16 = 16;

impl Image8 {
    /// A smaller copy, over white: the mean of the codes in each square.
    #[must_use]
    pub fn thumbnail(&self) -> Self {
        self.at_most(THUMBNAIL)
    }

    /// A copy at most some pixels across, over white: the mean of the codes in each square.
    #[must_use]
    pub fn at_most(&self, across: usize) -> Self {
        self.over_white().reduced(across, |square| {
            let count = square.len() as u32;
            std::array::from_fn(|c| (square.iter().map(|p| u32::from(p[c])).sum::<u32>() / count) as u8)
        })
    }

    /// A smaller picture of the differences to another of the same size: the largest in each square, magnified.
    #[must_use]
    pub fn difference(&self, other: &Self) -> Self {
        Self::opaque(self.width, self.differences(other)).reduced(THUMBNAIL, |square| {
            let largest = |c: usize| square.iter().map(|p| p[c]).max().unwrap_or(0);
            std::array::from_fn(|c| (u16::from(largest(c)) * MAGNIFIED).min(255) as u8)
        })
    }

    /// One pixel for each square of them.
    fn reduced(&self, across: usize, pixel: impl Fn(&[[u8; 3]]) -> [u8; 3]) -> Self {
        let edge = self.width.div_ceil(across).max(1);
        let (width, height) = (self.width.div_ceil(edge), self.height().div_ceil(edge));
        let square = |i: usize| {
            let (left, top) = (i % width * edge, i / width * edge);
            let rows = (top..(top + edge).min(self.height())).map(|y| &self.pixels[y * self.width..][..self.width]);
            let square: Vec<[u8; 3]> =
                rows.flat_map(|row| &row[left..(left + edge).min(self.width)]).copied().collect();
            pixel(&square)
        };
        Self::opaque(width, (0..width * height).map(square).collect())
    }
}

/// The whole page; `thumbnails` are those of the points, where there are any. What one needs to choose comes first, the rest
/// folds out.
pub fn page(tradeoff: &Tradeoff, thumbnails: &[Option<Thumbnails>]) -> String {
    let name = escape(tradeoff.scene.as_deref().unwrap_or("a scene without a name"));
    let mut page = format!(
        "<!doctype html><html lang=\"en\"><meta charset=\"utf-8\"><meta name=\"viewport\" content=\"width=device-width\">\
         <title>What accuracy costs: {name}</title><style>{STYLE}{}{}</style><main><h1>What accuracy costs: {name}</h1>\
         <p class=\"answer\">{}</p>",
        choice_plot::STYLE,
        plot::STYLE,
        escape(&tradeoff.choices.answer)
    );
    // Writing to a String cannot fail.
    pictures(&mut page, &tradeoff.choices);
    for (class, width) in [("broad", 1240.0), ("slim", 366.0)] {
        if let Some(plot) = choice_plot::plot(&tradeoff.choices, width) {
            let _ = write!(page, "<div class=\"{class}\">{plot}</div>");
        }
    }
    choices(&mut page, tradeoff);
    page.push_str("<details><summary>How it was measured</summary>");
    circumstances(&mut page, tradeoff);
    page.push_str("</details>");
    let _ = write!(
        page,
        "<details><summary>{} more settings: advice, plots, numbers and pictures</summary><ul>",
        tradeoff.points.len()
    );
    for sentence in &tradeoff.advice {
        let _ = write!(page, "<li>{}", escape(sentence));
    }
    page.push_str("</ul><h2>Difference against cost</h2><p>Dots are measured: the root mean square of the differences, and above it \
        the largest of any pixel and channel. The dashed line joins the settings that no other beats in both. Recursion: one sample \
        in the middle of each pixel, against the same samples followed as far as the reference. Both errors: against 64 \
        samples. Times here are of tracing alone.</p><div class=\"plots\">");
    for front in tradeoff.fronts.iter().filter(|front| !front.points.is_empty()) {
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
    page.push_str("</details></main>\n");
    page
}

/// Up to three pictures side by side, with their time and what they lack.
fn pictures(page: &mut String, choices: &Choices) {
    // All have the same shape.
    let shape = choices.size.map(f64::from);
    let _ = write!(page, "<div class=\"three\" style=\"--shape:{:.4}\">", shape[0] / shape[1]);
    for index in choices.shown() {
        let choice = &choices.all[index];
        let (Some(picture), Some(ms)) = (&choice.picture, choice.request_ms) else { continue };
        let (class, role) = match Some(index) {
            taken if taken == choices.recommended => (" class=\"take\"", "Take this: "),
            quicker if quicker == choices.quicker => ("", "Quicker: "),
            exact if exact == choices.exact && choices.knows_exact() => ("", "Exact: "),
            _ => ("", ""),
        };
        let _ = write!(page, "<figure{class}>");
        image(page, &picture.at_most(LARGE), &choice.name);
        let _ = write!(
            page,
            "<figcaption><b>{role}{}</b><span class=\"time\">{}</span><span>{}</span></figcaption></figure>",
            choice.name,
            duration(ms),
            in_short(choices, choice)
        );
    }
    page.push_str("</div>");
}

fn image(page: &mut String, picture: &Image8, name: &str) {
    let (width, height) = (picture.width, picture.height());
    let png = data_encoding::BASE64.encode(&png_of(width as u32, height as u32, picture.pixels.as_flattened()));
    let _ =
        write!(page, "<img width=\"{width}\" height=\"{height}\" alt=\"{name}\" src=\"data:image/png;base64,{png}\">");
}

/// What the numbers mean, and the choices in a table.
fn choices(page: &mut String, tradeoff: &Tradeoff) {
    let choices = &tradeoff.choices;
    let [width, height] = choices.size;
    let is_scaled = choices.size != tradeoff.circumstances.asked_size;
    let scaled = if is_scaled { "; times are scaled up to the size asked for" } else { "" };
    page.push_str("<p class=\"note\">");
    if let Some(reference) = &choices.reference {
        let _ = write!(
            page,
            "A code is one of the 255 steps from black to full brightness. A difference of 1 is invisible; 2 to 10 codes are seen only \
             if the two pictures take turns in one place, more than 30 are obvious. Compared are pictures of {width} × {height} \
             pixels with {}, all but the worst pixel of 1000{scaled}. ",
            against(reference)
        );
    } else {
        let _ = write!(page, "Pictures of {width} × {height} pixels were rendered{scaled}. ");
    }
    let _ = write!(
        page,
        "A time is that of a whole request: loading the scene ({}), tracing, and writing the PNG ({}).",
        duration(choices.load_ms),
        duration(choices.encode_ms)
    );
    for remark in &choices.remarks {
        let _ = write!(page, " {}", escape(remark));
    }
    page.push_str("</p><table class=\"choice\"><thead><tr><th>setting<th>time<th>codes off<th>how it is seen<th>proved<th>ask for it with\
        </thead><tbody>");
    for (index, choice) in choices.all.iter().enumerate() {
        let class = if choices.recommended == Some(index) { " class=\"best\"" } else { "" };
        let number = choice.request_ms.map_or_else(String::new, |_| format!("<i>{}</i> ", index + 1));
        let _ = write!(
            page,
            "<tr{class}><th>{number}{}<td>{}<td class=\"codes\">{}<td>{}<td class=\"proved\">{}<td><code>{}</code>",
            choice.name,
            choice.request_ms.map_or_else(|| "no time".to_owned(), duration),
            choice.codes().map_or_else(|| "–".to_owned(), figure),
            if choice.request_ms.is_some() { in_short(choices, choice) } else { "–".to_owned() },
            proved(choice),
            escape(&query(choices, choice)),
        );
    }
    page.push_str("</tbody></table>");
}

/// What differences are from.
fn against(reference: &Reference) -> String {
    match reference.max_codes {
        Some(codes) => format!("that of proved:{codes} in double precision, as there was no time for the exact one"),
        None if reference.is_exact() => "the exact one".to_owned(),
        None => format!(
            "the most exact one there was time for (rays are followed down to a weight of {})",
            brief(reference.min_weight)
        ),
    }
}

fn proved(choice: &Choice) -> String {
    let depth = choice.settings.max_depth.filter(|_| choice.settings.max_codes.is_some());
    match (choice.proved_codes, depth) {
        (Some(codes), Some(depth)) => format!("≤ {codes} (to depth {depth})"),
        (Some(codes), None) => format!("≤ {codes}"),
        (None, _) => "–".to_owned(),
    }
}

/// What to add to a request's address for a choice.
fn query(choices: &Choices, choice: &Choice) -> String {
    let s = &choice.settings;
    let mut query = match s.max_codes {
        Some(codes) => format!("accuracy=proved:{codes}"),
        None => {
            format!("accuracy=fixed&max_depth={}&min_weight={}", s.max_depth.unwrap_or_default(), s.min_weight)
        }
    };
    if choices.is_adaptive {
        let _ = write!(query, "&samples={}", s.samples);
    }
    // Else it is as the scene asks.
    if choice.name == NO_ANTIALIASING {
        query.push_str("&antialias=false");
    }
    if s.precision == Precision::Double {
        query.push_str("&precision=double");
    }
    query
}

fn circumstances(page: &mut String, tradeoff: &Tradeoff) {
    let c = &tradeoff.circumstances;
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
    let Some(r) = &tradeoff.reference else {
        page.push_str("<p>There was no time for pictures to measure errors against.</p>");
        return;
    };
    let (depth, step) = (
        r.max_depth.map_or_else(String::new, |depth| format!(" with depth {depth}")),
        match r.finer {
            Some(Finer { min_weight, max_codes: 0 }) => {
                format!(
                    " On the small picture of the warm-up, min_weight {} instead changes no code.",
                    brief(min_weight)
                )
            }
            Some(Finer { min_weight, max_codes }) => format!(
                " On the small picture of the warm-up, min_weight {} instead changes up to {max_codes} codes: the \
             reference itself is not exact.",
                brief(min_weight)
            ),
            None if r.max_codes.is_some() => " There was no time for better ones.".to_owned(),
            None if r.min_weight == 0.0 => " That follows every ray.".to_owned(),
            None => " There was no time to see what following still lighter rays would change.".to_owned(),
        },
    );
    let end = r.max_codes.map_or_else(
        || format!("min_weight {}", brief(r.min_weight)),
        |codes| format!("proved to at most {codes} codes"),
    );
    let dropped = if r.dropped == 0 {
        String::new()
    } else {
        format!(" {} of its rays were dropped at the limit for one sample.", r.dropped)
    };
    let _ = write!(
        page,
        "<p>Errors are <em>measured</em>, in 8-bit codes, against pictures in double precision{depth} and {end}.{step}{dropped} \
         None of them is a proof. That of recursion (with rounding) and that of too few samples are kept apart.</p>",
    );
}

/// All points, the quickest first.
fn table(page: &mut String, tradeoff: &Tradeoff) {
    page.push_str("<h2>All settings</h2><p>The quickest first; those in green are beaten by no other in both time and difference. \
        Milliseconds of tracing; differences in codes: the largest, and the root mean square (RMS).</p>\
        <p class=\"hint\">The table goes on to the right: swipe.</p><div class=\"wide\"><table><thead><tr><th rowspan=\"2\">settings<th rowspan=\"2\">ms<th rowspan=\"2\">rays\
        <th colspan=\"2\">recursion<th>samples<th colspan=\"3\">both<th rowspan=\"2\">proved\
        <tr><th>largest<th>RMS<th>RMS<th>largest<th>RMS<th>equal pixels</thead><tbody>");
    let front = tradeoff.fronts.iter().find(|f| (f.error, f.cost) == (Source::Total, Cost::Time));
    let mut order: Vec<usize> = (0..tradeoff.points.len()).collect();
    let ms = |i: usize| tradeoff.points[i].cost(Cost::Time).unwrap_or(f64::INFINITY);
    order.sort_by(|&a, &b| ms(a).total_cmp(&ms(b)));
    for index in order {
        let best = front.is_some_and(|front| front.points.contains(&index));
        let class = if best { " class=\"best\"" } else { "" };
        let _ = write!(page, "<tr{class}><th>{}", tradeoff.points[index].settings);
        row(page, &tradeoff.points[index]);
    }
    page.push_str("</tbody></table></div>");
}

fn row(page: &mut String, point: &Point) {
    match (&point.time, &point.rays) {
        (Some(time), Some(rays)) => {
            let [median, min, max] = [time.median_ms, time.min_ms, time.max_ms].map(figure);
            let _ = write!(
                page,
                "<td title=\"median of {}, {min} to {max}\">{median}\
                 <td title=\"camera {}, shadow {}, reflected {}, transmitted {}, gathered {}\">{}",
                time.repeats,
                rays.camera,
                rays.shadow,
                rays.reflected,
                rays.transmitted,
                rays.gathered,
                rays.total()
            );
        }
        _ => page.push_str("<td colspan=\"2\">no time"),
    }
    let cell = |page: &mut String, error: Option<&Difference>, of: fn(&Difference) -> String| {
        let _ = write!(page, "<td>{}", error.map_or_else(|| "–".to_owned(), of));
    };
    let Errors { truncation, sampling, total } = &point.measured;
    cell(page, truncation.as_ref(), |e| figure(e.codes.error.max));
    cell(page, truncation.as_ref(), |e| figure(e.rms_codes));
    cell(page, sampling.as_ref(), |e| figure(e.rms_codes));
    cell(page, total.as_ref(), |e| figure(e.codes.error.max));
    cell(page, total.as_ref(), |e| figure(e.rms_codes));
    cell(page, total.as_ref(), |e| percent(e.codes.identical));
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
                image(page, picture, name);
            }
        }
        let bold = if point.settings.precision == Precision::Double { "double" } else { "single" };
        let _ = write!(page, "<figcaption class=\"{bold}\">{}</figcaption></figure>", point.settings);
    }
    page.push_str("</div>");
}

const STYLE: &str = "\
:root{color-scheme:light dark}body{font:15px/1.5 system-ui,sans-serif;margin:0;color:#222;background:#fafafa}\
main{max-width:1240px;margin:0 auto;padding:10px 12px 2em}h1{font-size:17px;line-height:1.3;margin:0;color:#555;font-weight:600}h2{margin-top:1.6em}figure{margin:0}\
.answer{font-size:22px;line-height:1.3;margin:.3em 0 .5em;text-wrap:pretty}.note{margin:.8em 0;color:#555;max-width:75em}\
.three{display:grid;grid-template-columns:repeat(3,minmax(0,1fr));gap:14px;margin-bottom:10px}\
.three img{display:block;width:min(100%,var(--shape)*min(235px,29vh));height:auto;border-radius:4px}.three .take img{outline:3px solid #1a7f37}\
.three figcaption{width:min(100%,var(--shape)*min(235px,29vh));min-width:min(100%,260px);display:grid;grid-template-columns:1fr auto;gap:0 .8em;padding-top:4px;color:inherit;font-size:15px;line-height:1.35}\
.three figcaption>:last-child{grid-column:1/-1}.time{font-variant-numeric:tabular-nums;font-weight:700}.choices{display:block;width:100%;height:auto;border-radius:4px}.slim{display:none}\
details{border-top:1px solid #ddd;padding:.6em 0}details:first-of-type{margin-top:1.2em}summary{cursor:pointer;font-weight:600}\
.plots{display:grid;grid-template-columns:repeat(auto-fit,minmax(min(100%,480px),1fr));gap:1em}figcaption{color:#555;font-size:.85em}\
.plots svg{width:100%;height:auto;border:1px solid #ddd}.wide{overflow-x:auto}.hint{display:none}.choice td{white-space:normal}.choice td:last-child{text-align:left;overflow-wrap:anywhere}\
.choice i{display:inline-block;min-width:1.3em;color:#666;font-style:normal;font-weight:700}\
table{border-collapse:collapse;font-size:.87em;font-variant-numeric:tabular-nums;background:#fff}\
td,th{border:1px solid #ddd;padding:.2em .5em;text-align:right;white-space:nowrap}th{background:#eef1f6;font-weight:600;text-align:center}\
tbody th{text-align:left;font-weight:400;background:none}.best{background:#e8f4e8}\
.sheet{display:grid;grid-template-columns:repeat(auto-fill,minmax(min(100%,400px),1fr));gap:1em}.sheet img{width:calc(33.3% - 3px);height:auto;margin-right:3px}\
@media(max-width:1100px){.choice,.choice tbody{display:block}.choice thead{display:none}.choice tr{display:grid;grid-template-columns:1fr auto;gap:0 1em;border:1px solid #ddd;border-bottom:0;padding:.3em .5em}\
.choice tr:last-child{border-bottom:1px solid #ddd}.choice td,.choice th{display:block;border:0;padding:0;text-align:left;white-space:normal;overflow-wrap:anywhere}.choice th{font-weight:600}.choice .codes{display:none}\
.choice td:last-child{grid-column:1/-1}.proved::before{content:\"proved: \"}}\
@media(max-width:700px){h1{font-size:14px}.answer{font-size:15px}.three{grid-template-columns:1fr;gap:6px;margin-bottom:6px}.three figure{display:grid;grid-template-columns:min(46vw,var(--shape)*88px) 1fr;gap:10px;align-items:center}\
.three img{width:100%}.three figcaption{width:auto;min-width:0;grid-template-columns:1fr}.broad{display:none}.slim{display:block}.hint{display:block;color:#666;font-size:.87em}.plots figure{overflow-x:auto}.plots svg{min-width:560px}}\
@media(prefers-color-scheme:dark){body{color:#ddd;background:#15171a}h1,.note{color:#aaa}table{background:#1b1d21}td,th,.plots svg,details{border-color:#3a3d44}\
thead th{background:#262a31}.best{background:#1f3324}figcaption{color:#aaa}.three .take img{outline-color:#63d387}}";

fn escape(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn small_pictures_keep_single_wrong_pixels() {
        let (width, height) = (3 * THUMBNAIL + 1, 5);
        let black = Image8::opaque(width, vec![[0; 3]; width * height]);
        let mut one = black.clone();
        one.pixels[2 * width + 7] = [0, 2, 200];
        let small = one.difference(&black);
        assert_eq!((small.width, small.height()), (109, 2));
        assert_eq!(small.pixels[1], [0, 32, 255]);
        assert_eq!(small.pixels.iter().filter(|p| **p != [0; 3]).count(), 1);
        let grey = Image8::opaque(width, vec![[9; 3]; width * height]);
        assert!(grey.thumbnail().pixels.iter().all(|p| *p == [9; 3]));
    }

    #[test]
    fn names_are_no_markup() {
        assert_eq!(escape("<a b=\"&\">"), "&lt;a b=&quot;&amp;&quot;&gt;");
    }
}
