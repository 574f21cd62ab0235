//! Runs every command and every request of the README and the book, and compares what they show.
//!
//! The word after a fence says what a block is, the words after that what to do with it:
//!
//! | Block | What happens |
//! |---|---|
//! | `sh` | each line is run and must succeed |
//! | `console` | lines after `$ ` (and `> `) are run; if others follow, they are the output |
//! | `console times` | numbers may differ in lines with times |
//! | `console numbers` | numbers may differ in all lines |
//! | `… serve` | the service is started; later commands of the page talk to it |
//! | `… skip-REASON` | the block is not run; [`REASONS`] has the reasons there are |
//! | `console refused` | the requests are refused |
//! | `json scene` | the scene is checked and rendered |
//! | `toml file` | the block is written to the file that its first line names |
//! | `text` | nothing |
//!
//! In an output a line `...` stands for any lines, and `…` within a line for anything.

use super::pages::{Block, Page, book};
use super::shell::{Outcome, Shell};
use std::thread;

/// Why a block is not run.
const REASONS: &[(&str, &str)] = &[
    ("skip-broker", "it needs a NATS server"),
    ("skip-docker", "it needs a container engine"),
    ("skip-itself", "it runs this test"),
    ("skip-minutes", "it takes minutes"),
    ("skip-network", "it installs other programs"),
];

fn reason(block: &Block) -> Option<&'static str> {
    REASONS.iter().find(|(mark, _)| block.is_marked(mark)).map(|(_, reason)| *reason)
}

#[test]
fn every_block_is_run_or_says_why_not() {
    let mut skipped = Vec::new();
    for block in book().iter().flat_map(|page| &page.blocks) {
        let known: &[&str] = match block.language.as_str() {
            "sh" => &["serve"],
            "console" => &["numbers", "refused", "times"],
            "json" => &["scene"],
            "toml" => &["file"],
            "text" => &[],
            other => panic!("{}: no test knows what to do with `{other}`", block.place),
        };
        for mark in &block.marks {
            let is_reason = REASONS.iter().any(|(reason, _)| reason == mark);
            assert!(known.contains(&mark.as_str()) || is_reason, "{}: what is `{mark}`?", block.place);
        }
        let needs_mark = matches!(block.language.as_str(), "json" | "toml");
        assert!(!needs_mark || !block.marks.is_empty(), "{}: a block that no test looks at", block.place);
        skipped.extend(reason(block).map(|reason| format!("{}: {reason}", block.place)));
    }
    println!("{} blocks are not run:\n{}", skipped.len(), skipped.join("\n"));
}

#[test]
fn commands_and_requests_do_what_the_documents_show() {
    let pages = book();
    let failures: Vec<String> = thread::scope(|scope| {
        let running: Vec<_> = pages.iter().map(|page| scope.spawn(|| run(page))).collect();
        running.into_iter().flat_map(|page| page.join().expect("no panic")).collect()
    });
    assert!(failures.is_empty(), "{}", failures.join("\n\n"));
}

/// Runs a page, and says what went wrong.
fn run(page: &Page) -> Vec<String> {
    let blocks: Vec<&Block> = page.blocks.iter().filter(|block| reason(block).is_none()).collect();
    if blocks.is_empty() {
        return Vec::new();
    }
    let mut shell = Shell::start(&page.path);
    let mut failures = Vec::new();
    for block in blocks {
        let mut check = |command: &str, expected: &[String]| {
            let mut outcome = shell.run(command);
            // A pilot has some milliseconds, and on a busy machine little of a processor in them.
            let tries = if command.starts_with("strahl explain") { 20 } else { 1 };
            for _ in 1..tries {
                if judge(&outcome, block, expected).is_ok() {
                    break;
                }
                outcome = shell.run(command);
            }
            if let Err(why) = judge(&outcome, block, expected) {
                failures.push(format!("{}: $ {command}\n{why}; it shows:\n{}", block.place, outcome.shown.join("\n")));
            }
        };
        match block.language.as_str() {
            "sh" if block.is_marked("serve") => shell.serve(block.text().trim()),
            "sh" => commands(block).iter().for_each(|command| check(command, &[])),
            "console" => transcript(block).iter().for_each(|(command, expected)| check(command, expected)),
            "json" => {
                shell.write("shown.json", &block.text());
                for (command, expected) in [
                    ("strahl validate shown.json", ["shown.json is valid".to_owned()].as_slice()),
                    ("strahl render shown.json --width 96 --height 54 -o shown.png", &[]),
                ] {
                    let outcome = shell.run(command);
                    if let Err(why) = judge(&outcome, block, expected) {
                        failures.push(format!("{}: {why}; it shows:\n{}", block.place, outcome.shown.join("\n")));
                    }
                }
            }
            "toml" => shell.write(block.lines[0].trim_start_matches(['#', ' ']), &block.text()),
            _ => {}
        }
    }
    failures
}

/// The commands of a block of nothing else. A backslash goes on with the next line.
fn commands(block: &Block) -> Vec<String> {
    let text = block.text().replace("\\\n", " ");
    text.lines().map(str::trim).filter(|line| !line.is_empty() && !line.starts_with('#')).map(str::to_owned).collect()
}

/// Commands and what is shown after each.
fn transcript(block: &Block) -> Vec<(String, Vec<String>)> {
    let mut steps: Vec<(String, Vec<String>)> = Vec::new();
    for line in &block.lines {
        if let Some(command) = line.strip_prefix("$ ") {
            steps.push((command.to_owned(), Vec::new()));
            continue;
        }
        let (command, shown) = steps.last_mut().unwrap_or_else(|| panic!("{}: no `$ ` comes first", block.place));
        match line.strip_prefix("> ") {
            Some(more) if shown.is_empty() => *command += &format!("\n{more}"),
            _ => shown.push(line.clone()),
        }
    }
    steps
}

fn judge(outcome: &Outcome, block: &Block, expected: &[String]) -> Result<(), String> {
    let refused = block.is_marked("refused");
    if outcome.exit_code != 0 {
        return Err(format!("it ends with exit code {}", outcome.exit_code));
    }
    if let Some(status) = outcome.statuses.iter().find(|status| (400..600).contains(*status) != refused) {
        return Err(format!("the answer's status is {status}"));
    }
    let may_differ = |line: &str| {
        let has_time = ["dur=", " ms"].iter().any(|part| line.contains(part));
        block.is_marked("numbers") || (block.is_marked("times") && has_time)
    };
    let plain = |lines: &[String]| lines.iter().map(|line| simplified(line, may_differ(line))).collect::<Vec<_>>();
    // A block may show commands alone.
    if expected.is_empty() || matches_lines(&plain(expected), &plain(&outcome.shown)) {
        Ok(())
    } else {
        Err("the document shows something else".to_owned())
    }
}

/// A line as it is compared: without trailing spaces, and if numbers may differ, with 0 for each and one space for several.
fn simplified(line: &str, numbers_may_differ: bool) -> String {
    if !numbers_may_differ {
        return line.trim_end().to_owned();
    }
    let mut out = String::new();
    for word in line.split_whitespace() {
        let mut inside = false;
        for (i, c) in word.char_indices() {
            let goes_on = inside && ".,".contains(c) && word[i + 1..].starts_with(|next: char| next.is_ascii_digit());
            if c.is_ascii_digit() || goes_on {
                if !inside {
                    out.push('0');
                }
                inside = true;
            } else {
                inside = false;
                out.push(c);
            }
        }
        out.push(' ');
    }
    out.trim_end().to_owned()
}

/// Whether lines are as expected, where a line `...` stands for any of them.
fn matches_lines(expected: &[String], lines: &[String]) -> bool {
    match expected.split_first() {
        None => lines.is_empty(),
        Some((first, rest)) if first == "..." => {
            (0..=lines.len()).any(|skipped| matches_lines(rest, &lines[skipped..]))
        }
        Some((first, rest)) => {
            lines.split_first().is_some_and(|(line, others)| matches_line(first, line) && matches_lines(rest, others))
        }
    }
}

/// Whether a line is as expected, where `…` stands for anything.
fn matches_line(expected: &str, line: &str) -> bool {
    match expected.split_once('…') {
        None => expected == line,
        Some((start, rest)) => line.strip_prefix(start).is_some_and(|left| {
            left.char_indices().map(|(i, _)| i).chain([left.len()]).any(|i| matches_line(rest, &left[i..]))
        }),
    }
}

#[test]
fn outputs_are_compared_as_they_say() {
    assert_eq!(simplified("trace;dur=265.489, 4,302,113   rays", true), "trace;dur=0, 0 rays");
    assert_eq!(simplified("a  b ", false), "a  b");
    assert!(matches_line("etag: \"…\"", "etag: \"i_t3\"") && !matches_line("etag: \"…\"", "etag: i_t3"));
    let lines = |text: &str| text.lines().map(str::to_owned).collect::<Vec<_>>();
    assert!(matches_lines(&lines("a\n...\nd"), &lines("a\nb\nc\nd")));
    assert!(!matches_lines(&lines("a\n...\nd"), &lines("a\nb\nc")));
}
