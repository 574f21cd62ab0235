//! Faults of models as problems of scenes, with their places.

use crate::models::{Fault, Faults, Kind, ModelFormat, Place, Warning, gltf};
use crate::scene::Problems;
use crate::scene::description::{Fidelity, ImportWarning};
use crate::scene::limits::IMPORT_WARNING_CHARACTERS;
use crate::scene::locate::{innermost, locate, place};
use crate::scene::problem::{Code, Problem};

/// The faults of a file, located in it.
pub(super) fn located(format: ModelFormat, bytes: &[u8], Faults(faults): Faults) -> Problems {
    let json = if format == ModelFormat::Gltf { gltf::json_of(bytes) } else { &[] };
    placed(format, bytes, Problems(faults.into_iter().map(|fault| problem(json, fault)).collect()))
}

/// The same of problems that may have no place yet: that of the innermost value of the file that their pointer leads to, or the
/// beginning of the file.
pub(super) fn placed(format: ModelFormat, bytes: &[u8], Problems(problems): Problems) -> Problems {
    // Those in the binary have no line.
    let (mut all, in_binary): (Vec<_>, Vec<_>) = problems.into_iter().partition(|problem| problem.offset.is_none());
    // A pointer leads to what a request asks for.
    let without = |problem: &&mut Problem| problem.line.is_none() && problem.pointer.is_empty();
    match format {
        ModelFormat::Gltf => locate(gltf::json_of(bytes), &mut all),
        ModelFormat::Stl => all.iter_mut().filter(without).for_each(|problem| problem.offset = Some(0)),
        ModelFormat::Obj | ModelFormat::Ply => {
            all.iter_mut().filter(without).for_each(|problem| (problem.line, problem.column) = (Some(1), Some(1)));
        }
    }
    all.extend(in_binary);
    Problems(all)
}

fn problem(json: &[u8], fault: Fault) -> Problem {
    let Fault { pointer, kind, detail, place: at } = fault;
    let problem = Problem::new(pointer, code(kind), detail);
    match at {
        Place::Pointer => problem,
        Place::Line(line, column) => Problem { line: Some(line), column: Some(column), ..problem },
        Place::Offset(offset) => Problem { offset: Some(offset), ..problem },
        Place::Json(offset) => {
            let (line, column) = place(json, offset);
            let found = innermost(json, offset);
            // A value that ends where the fault is belongs to what is known of its pointer.
            let mut pointer = if found.starts_with(&problem.pointer) { found } else { problem.pointer.clone() };
            // What lacks a key is the object around the last value.
            if kind == Kind::MissingKey && pointer.len() > problem.pointer.len() {
                pointer.truncate(pointer.rfind('/').unwrap_or(0));
                return Problem { pointer, ..problem };
            }
            Problem { pointer, line: Some(line), column: Some(column), ..problem }
        }
    }
}

fn code(kind: Kind) -> Code {
    match kind {
        Kind::Invalid => Code::InvalidModel,
        Kind::WrongType => Code::WrongType,
        Kind::MissingKey => Code::MissingKey,
        Kind::OutOfRange => Code::OutOfRange,
        Kind::OutOfBounds => Code::OutOfBounds,
        Kind::UnknownReference => Code::UnknownReference,
        Kind::MissingPart => Code::MissingPart,
        Kind::Cycle => Code::Cycle,
        Kind::Degenerate => Code::Degenerate,
        Kind::Limit => Code::Limit,
        Kind::Unsupported => Code::Unsupported,
        Kind::Cancelled => Code::Cancelled,
    }
}

/// A warning as the scene keeps it, which holds for one fidelity or for each.
pub(super) fn of_warning(warning: &Warning, fidelity: Option<Fidelity>) -> ImportWarning {
    let detail = warning.to_string().chars().take(IMPORT_WARNING_CHARACTERS.max as usize).collect();
    ImportWarning { code: warning.subject, detail, fidelity }
}
