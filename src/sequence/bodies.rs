//! Changing the bodies of a scene from frame to frame. Lists in which nothing changes stay shared with the scene, so that they are
//! not built again.

use crate::scene::description::{Description, Object};
use std::sync::Arc;

/// Whether `concerns` is true of any object of a scene, at any depth.
pub(super) fn any_of(scene: &Description, concerns: impl Fn(&Object) -> bool) -> bool {
    scene.objects.iter().chain(scene.definitions.values().flatten()).any(|object| any(object, &concerns))
}

/// Changes the objects that `concerns` is true of, at any depth. The scene's reader limits how deep groups are.
pub(super) fn change(scene: &mut Description, concerns: impl Fn(&Object) -> bool, mut change: impl FnMut(&mut Object)) {
    if scene.objects.iter().any(|object| any(object, &concerns)) {
        Arc::make_mut(&mut scene.objects).iter_mut().for_each(|object| each(object, &concerns, &mut change));
    }
    if scene.definitions.values().flatten().any(|object| any(object, &concerns)) {
        for (_, objects) in Arc::make_mut(&mut scene.definitions).iter_mut() {
            objects.iter_mut().for_each(|object| each(object, &concerns, &mut change));
        }
    }
}

fn any(object: &Object, concerns: &impl Fn(&Object) -> bool) -> bool {
    let inside = match object {
        Object::Group(group) => group.objects.iter().any(|object| any(object, concerns)),
        _ => false,
    };
    inside || concerns(object)
}

fn each(object: &mut Object, concerns: &impl Fn(&Object) -> bool, change: &mut impl FnMut(&mut Object)) {
    if let Object::Group(group) = object {
        group.objects.iter_mut().for_each(|object| each(object, concerns, change));
    }
    if concerns(object) {
        change(object);
    }
}
