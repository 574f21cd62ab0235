//! Parts of a body that are read on their own: a scene, a ray.

use crate::service::error::Error;
use serde_json::value::RawValue;
use strahl::scene::{Problems, problem};

/// Where a part is in the body of a request. By default it is the whole body.
#[derive(Debug, Default)]
pub(crate) struct BodyPart {
    pointer: String,
    /// Lines and columns before it.
    lines: u32,
    columns: u32,
}

impl BodyPart {
    /// The part of a body at a pointer.
    pub(crate) fn of(body: &[u8], pointer: String, part: &RawValue) -> Self {
        let before = &body[..part.get().as_ptr() as usize - body.as_ptr() as usize];
        let lines = before.iter().filter(|byte| **byte == b'\n').count() as u32;
        let columns = before.iter().rev().take_while(|byte| **byte != b'\n').count() as u32;
        Self { pointer, lines, columns }
    }

    /// Problems of the part, with places in the body.
    pub(crate) fn problems(&self, problems: Problems) -> Problems {
        let Self { pointer, lines, columns } = self;
        let place = |problem: problem::Problem| problem::Problem {
            pointer: format!("{pointer}{}", problem.pointer),
            column: problem.column.map(|column| if problem.line == Some(1) { column + columns } else { column }),
            line: problem.line.map(|line| line + lines),
            ..problem
        };
        Problems(problems.0.into_iter().map(place).collect())
    }

    /// The same for an error, which may be of another kind.
    pub(crate) fn error(&self, error: Error) -> Error {
        match error {
            Error::Scene(problems) => Error::Scene(self.problems(problems)),
            error => error,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::HashMap;

    #[test]
    fn problems_of_a_scene_inside_a_body_are_found_in_the_body() {
        let body = "{\"rays\": [],\n \"scene\": {\n  \"version\": 2}}".as_bytes();
        let parts: HashMap<&str, &RawValue> = serde_json::from_slice(body).unwrap();
        let at = |part: &BodyPart, line, column| {
            let problem = problem::Problem::new("/version", problem::Code::OutOfRange, "must be 1");
            let problems = Problems::one(problem::Problem { line: Some(line), column: Some(column), ..problem });
            let Problems(found) = part.problems(problems);
            (found[0].pointer.clone(), found[0].line, found[0].column)
        };
        let part = BodyPart::of(body, "/scene".into(), parts["scene"]);
        assert_eq!(at(&part, 1, 1), ("/scene/version".into(), Some(2), Some(11)));
        assert_eq!(at(&part, 2, 14), ("/scene/version".into(), Some(3), Some(14)));
        assert_eq!(at(&BodyPart::default(), 2, 14), ("/version".into(), Some(2), Some(14)));
    }
}
