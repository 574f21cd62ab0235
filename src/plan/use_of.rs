//! What the objects of a scene use: materials, hollowness, smooth normals, placements. Definitions that no instance
//! places do not count.

use super::explain::{MAX_POINTERS, is_placed, moves};
use crate::scene::description::{Description, Mesh, Object};
use crate::scene::problem::push_token;
use std::collections::HashSet;

/// What is used, with the pointers of the first objects that use it.
#[derive(Debug, Default)]
pub(super) struct Uses {
    pub(super) materials: HashSet<String>,
    pub(super) default_material: bool,
    /// Materials that light may be inside of: those of closed bodies that are not hollow.
    pub(super) filled: HashSet<String>,
    pub(super) hollow: Vec<String>,
    pub(super) smooth: Vec<String>,
    pub(super) placed: Vec<String>,
    pub(super) moving: Vec<String>,
}

/// Walks all objects that can be seen.
pub(super) fn uses(description: &Description) -> Uses {
    let mut uses = Uses::default();
    let mut definitions = HashSet::new();
    uses.walk("/objects", &description.objects, description, &mut definitions);
    uses
}

impl Uses {
    fn walk<'a>(
        &mut self,
        list: &str,
        objects: &'a [Object],
        description: &'a Description,
        definitions: &mut HashSet<&'a str>,
    ) {
        for (i, object) in objects.iter().enumerate() {
            let pointer = || format!("{list}/{i}/{}", object.kind());
            if is_placed(object) && self.placed.len() < MAX_POINTERS {
                self.placed.push(pointer());
            }
            if moves(object) && self.moving.len() < MAX_POINTERS {
                self.moving.push(pointer());
            }
            match object {
                Object::Group(group) => {
                    self.walk(&format!("{}/objects", pointer()), &group.objects, description, definitions);
                }
                Object::Instance(instance) => {
                    if let Some(objects) = description.definitions.get(&instance.of)
                        && definitions.insert(&instance.of)
                    {
                        let list = push_token("/definitions", &instance.of);
                        self.walk(&list, objects, description, definitions);
                    }
                }
                _ => self.body(object, pointer),
            }
        }
    }

    fn body(&mut self, object: &Object, pointer: impl Fn() -> String) {
        let Some(look) = object.look() else { return };
        match look.material {
            Some(name) if !self.materials.contains(name) => {
                self.materials.insert(name.to_owned());
            }
            Some(_) => {}
            None => self.default_material = true,
        }
        if let (Some(name), true, false) = (look.material, is_closed(object), look.hollow)
            && !self.filled.contains(name)
        {
            self.filled.insert(name.to_owned());
        }
        if look.hollow && self.hollow.len() < MAX_POINTERS {
            self.hollow.push(pointer());
        }
        if matches!(object, Object::Mesh(Mesh { normals: Some(_), .. })) && self.smooth.len() < MAX_POINTERS {
            self.smooth.push(pointer());
        }
    }
}

/// Whether an object encloses a region that light is refracted into.
fn is_closed(object: &Object) -> bool {
    match object {
        Object::Sphere(_) | Object::Plane(_) | Object::Torus(_) | Object::Mesh(_) | Object::Box(_) => true,
        Object::Cylinder(o) => o.capped,
        Object::Cone(o) => o.capped,
        _ => false,
    }
}
