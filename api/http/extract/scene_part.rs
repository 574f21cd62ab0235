//! A scene that is a part of a body.

use serde_json::value::RawValue;
use strahl::scene::{Problems, problem};

/// Where a part of a body begins.
pub(crate) fn offset(body: &[u8], part: &RawValue) -> usize {
    part.get().as_ptr() as usize - body.as_ptr() as usize
}

/// The problems of a scene that is a part of a body, with places in that body: `at` is its pointer, and `start` where it begins.
pub(crate) fn inside(body: &[u8], at: &str, start: usize, problems: Problems) -> Problems {
    let before = &body[..start];
    let lines = before.iter().filter(|byte| **byte == b'\n').count() as u32;
    let columns = before.iter().rev().take_while(|byte| **byte != b'\n').count() as u32;
    let place = |problem: problem::Problem| problem::Problem {
        pointer: format!("{at}{}", problem.pointer),
        column: problem.column.map(|column| if problem.line == Some(1) { column + columns } else { column }),
        line: problem.line.map(|line| line + lines),
        ..problem
    };
    Problems(problems.0.into_iter().map(place).collect())
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::HashMap;

    #[test]
    fn problems_of_a_scene_inside_a_body_are_found_in_the_body() {
        let body = "{\"rays\": [],\n \"scene\": {\n  \"version\": 2}}".as_bytes();
        let parts: HashMap<&str, &RawValue> = serde_json::from_slice(body).unwrap();
        let at = |line, column| {
            let problem = problem::Problem::new("/version", problem::Code::OutOfRange, "must be 1");
            let problems = Problems::one(problem::Problem { line: Some(line), column: Some(column), ..problem });
            let Problems(found) = inside(body, "/scene", offset(body, parts["scene"]), problems);
            (found[0].pointer.clone(), found[0].line, found[0].column)
        };
        assert_eq!(at(1, 1), ("/scene/version".into(), Some(2), Some(11)));
        assert_eq!(at(2, 14), ("/scene/version".into(), Some(3), Some(14)));
    }
}
