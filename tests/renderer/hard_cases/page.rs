//! The scorecard as a page that needs nothing else.

use super::card::{Card, Row, truth_cells};
use super::summary::{SOURCES, Summary};
use std::fmt::Write;

/// The whole page.
pub fn page(card: &Card, summary: &Summary) -> String {
    let mut page = format!("{HEAD}<h1>strahl: hard cases</h1>{LEAD}");
    overview(&mut page, summary);
    index(&mut page, card);
    truths(&mut page, card);
    cases(&mut page, card);
    page
}

fn overview(page: &mut String, summary: &Summary) {
    page.push_str("<h2>Summary</h2><table class=wide><tr><th><th>strahl single<th>strahl double<th>naive single<th>naive double<th>published by others\n");
    for line in &summary.lines {
        let [a, b, c, d] = line.cells.each_ref().map(|cell| escape(cell));
        let (what, published) = (escape(&line.what), escape(line.published));
        let [single, double] = line.sound.map(|sound| if sound { "pass" } else { "gap" });
        writeln!(page, "<tr><th>{what}<td class=\"n {single}\">{a}<td class=\"n {double}\">{b}<td class=\"n naive\">{c}<td class=\"n naive\">{d}<td><small>{published}</small>")
            .unwrap();
    }
    write!(page, "</table><p><small>{}</small></p>", escape(SOURCES)).unwrap();
}

/// Each case as a link, colored by the worse of its verdicts.
fn index(page: &mut String, card: &Card) {
    page.push_str("<h2>Cases</h2><p class=index>");
    let mut family = ' ';
    for case in &card.listed {
        let first = case.id.chars().next().unwrap_or(' ');
        if first != family && family != ' ' {
            page.push_str("<br>");
        }
        family = first;
        let verdicts: Vec<&str> = card.rows.iter().filter(|row| row.id == case.id).map(Row::verdict).collect();
        let worst = ["FAIL", "gap"].into_iter().find(|v| verdicts.contains(v)).unwrap_or("pass");
        write!(
            page,
            "<a class={worst} href=\"#{id}\" title=\"{what}\">{id}</a> ",
            id = case.id,
            what = escape(&case.what)
        )
        .unwrap();
    }
    page.push_str("</p>");
}

fn truths(page: &mut String, card: &Card) {
    page.push_str("<h2 id=exact>Exact answers</h2><p>Right answers of those asked where the format has one right answer and numbers for it. The others may go either way, but not wrong.</p><table><tr><th>questions<th>in all<th>strahl single<th>strahl double<th>naive single<th>naive double\n");
    for truth in &card.truths {
        let cells = truth_cells(truth);
        let all = [truth.strahl, truth.naive].concat();
        let cells = cells.iter().zip(all).enumerate().map(|(i, (cell, count))| {
            let class = if count.right == count.asked {
                "pass"
            } else if i < 2 {
                "FAIL"
            } else {
                "lost"
            };
            format!("<td class=\"n {class}\">{cell}")
        });
        writeln!(
            page,
            "<tr id={file}><th>{file}<td class=n>{}{}",
            truth.queries,
            cells.collect::<String>(),
            file = truth.file
        )
        .unwrap();
    }
    page.push_str("</table>");
}

fn cases(page: &mut String, card: &Card) {
    page.push_str("<h2>Each case</h2><table class=wide><tr><th>case<th>what<th>precision<th>verdict<th>figure<th>bound<th>unit<th>naive code beside it\n");
    for case in &card.listed {
        let rows: Vec<&Row> = card.rows.iter().filter(|row| row.id == case.id).collect();
        for (i, row) in rows.iter().enumerate() {
            let (figure, bound, unit, naive) = row.figures();
            let about = if i == 0 {
                format!(
                    "<tr id={id}><th rowspan={span}><a href=\"#{id}\">{id}</a><td rowspan={span}>{}<br><small>expected: {}<br>naive code: {}</small>",
                    escape(&case.what),
                    escape(&case.expected),
                    escape(&case.naive_failure),
                    id = case.id,
                    span = rows.len()
                )
            } else {
                "<tr>".to_owned()
            };
            let (precision, verdict, unit, naive) = (row.precision(), row.verdict(), escape(&unit), escape(&naive));
            let gap = row.gap.map_or(String::new(), |gap| format!("<br><small>known gap: {}</small>", escape(gap)));
            let figure = if figure == 0.0 { "0".to_owned() } else { format!("{figure:.3}") };
            writeln!(page, "{about}<td>{precision}<td class={verdict}>{verdict}<td class=n>{figure}<td class=n>{bound}<td>{unit}{gap}<td>{naive}")
                .unwrap();
        }
    }
    page.push_str("</table></main>\n");
}

const HEAD: &str = "<!doctype html><html lang=en><meta charset=utf-8><meta name=viewport content=\"width=device-width\">
<title>strahl: hard cases</title><style>
body{font:14px/1.45 system-ui,sans-serif;margin:0;color:#222;background:#fafafa}main{max-width:1200px;margin:2em auto;padding:0 1em}
h1{font-size:1.8em;margin:.2em 0}h2{margin:1.6em 0 .5em}table{border-collapse:collapse;background:#fff}.wide{width:100%}
td,th{border:1px solid #ddd;padding:.3em .6em;vertical-align:top;text-align:left}tr:first-child>th{background:#eef}
.n{text-align:right;font-variant-numeric:tabular-nums;white-space:nowrap}small{color:#555}
.pass{background:#d3f2d3}.gap{background:#ffe3a0}.FAIL{background:#ffb3b3;font-weight:bold}.lost,.naive{background:#f7e9e4}
.index a{display:inline-block;padding:.1em .4em;margin:.12em;border-radius:.3em;color:#222;text-decoration:none}
.index a:hover{outline:1px solid #666}tr:target>th,tr:target>td{outline:2px solid #58c}
</style><main>";

const LEAD: &str = "<p>Each case that renderers' tests and issue trackers name, in single and double precision: a figure against its \
bound. Beside it naive code, as textbooks have it, answers the same kind of question in the same precision; a case at which \
it does not fail would show nothing, so the test fails then. u is the unit roundoff, D the distance, cos that of \
the angle of incidence.</p>";

fn escape(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;")
}
