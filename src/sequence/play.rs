//! Models whose animations go on from frame to frame.

use super::bodies::{any_of, change};
use crate::scene::description::{Description, Object};
use crate::scene::problem::{Code, Problem};

/// Lets the animations of a scene's models go on by so many seconds. Models that say neither `animation` nor `t` stay at rest.
pub(super) fn go_on(scene: &mut Description, seconds: f64) -> Result<(), Problem> {
    if !any_of(scene, plays) {
        let detail = "nothing here plays: place a model in a scene, and say when its animation begins, as \
                      {\"model\": {\"asset\": \"sha256:…\", \"t\": 0}}";
        return Err(Problem::new("/objects", Code::MissingKey, detail));
    }
    if seconds != 0.0 {
        change(scene, plays, |object| {
            if let Object::Model(model) = object {
                model.t = Some(model.t.unwrap_or(0.0) + seconds);
            }
        });
    }
    Ok(())
}

fn plays(object: &Object) -> bool {
    matches!(object, Object::Model(model) if model.animation.is_some() || model.t.is_some())
}
