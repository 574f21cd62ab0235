//! What glows, as lights that are looked for: the triangles, boxes and balls of materials that glow alike everywhere.

use crate::control;
use crate::lanes::Real;
use crate::scene::description::{self as d, Description, Object};
use crate::scene::transform::affine;
use crate::scene::world::shows;
use crate::shading::emitters::{Emitters, Form, Lamp};
use crate::shading::material::Material;
use glam::{DAffine3, DVec3};
use std::collections::HashMap;

/// Most triangles and balls that are looked for, some 100 bytes each. Of more, rays find what glows by chance.
const MOST: usize = 1 << 20;
/// Most objects of definitions that are looked at, each time that they are placed. Instances of instances double it with each level.
const MOST_PLACED: usize = 1 << 22;

/// The lamps of a scene, if it has any. A material of which any body is none is left out: its glow is found by rays alone.
pub(super) fn emitters<R: Real>(description: &Description, materials: &[Material<R>]) -> Option<Emitters> {
    let glows = |(index, material): (usize, &Material<R>)| {
        let described = description.materials.get_index(index).map(|(_, described)| described);
        let alike = described.is_some_and(|described| !described.one_sided && is_alike(described));
        alike && !material.has_holes() && shows(material.emission)
    };
    let mut found = Found {
        description,
        glows: materials.iter().enumerate().map(glows).collect(),
        radiance: materials.iter().map(|material| material.emission.map(Real::to_f64)).collect(),
        lamps: Vec::new(),
        may_hold_lamps: HashMap::new(),
        placed: MOST_PLACED,
    };
    if !found.glows.contains(&true) {
        return None;
    }
    let all = found.walk(&description.objects, &DAffine3::IDENTITY, false);
    let Found { glows, mut lamps, .. } = found;
    lamps.retain(|lamp| glows[lamp.material]);
    all.then(|| Emitters::new(lamps, materials.len())).flatten()
}

/// Whether all of a material glows alike, seen from anywhere.
fn is_alike(material: &d::Material) -> bool {
    material
        .pbr
        .as_ref()
        .is_none_or(|pbr| pbr.emissive.textured().is_none() && !pbr.unlit && pbr.clearcoat.factor() == 0.0)
}

/// What was found so far.
struct Found<'a> {
    description: &'a Description,
    /// Whether a definition holds bodies of which any is a lamp, as far as it was asked.
    may_hold_lamps: HashMap<&'a str, bool>,
    /// How many objects of definitions may still be looked at.
    placed: usize,
    /// Whether the bodies of each material are lamps.
    glows: Vec<bool>,
    radiance: Vec<[f64; 3]>,
    lamps: Vec<Lamp>,
}

impl<'a> Found<'a> {
    /// Looks through objects that are placed by a map; false if there are too many.
    fn walk(&mut self, objects: &'a [Object], map: &DAffine3, moves: bool) -> bool {
        objects.iter().all(|object| !control::step(1) && self.take(object, map, moves) && self.lamps.len() <= MOST)
    }

    fn may_hold_lamps(&mut self, objects: &'a [Object]) -> bool {
        objects.iter().any(|object| match object {
            Object::Group(group) => self.may_hold_lamps(&group.objects),
            Object::Instance(instance) => {
                let of = instance.of.as_str();
                if let Some(known) = self.may_hold_lamps.get(of) {
                    return *known;
                }
                let objects = self.description.definitions.get(of);
                let holds = objects.is_some_and(|objects| self.may_hold_lamps(objects));
                self.may_hold_lamps.insert(of, holds);
                holds
            }
            _ => self.material_of(object).is_some_and(|material| self.glows[material]),
        })
    }

    fn material_of(&self, object: &Object) -> Option<usize> {
        let name = object.appearance()?.material?;
        self.description.materials.get_index_of(name)
    }

    fn take(&mut self, object: &'a Object, map: &DAffine3, moves: bool) -> bool {
        let placed = |transform: &d::Transform| *map * affine(transform).unwrap_or(DAffine3::IDENTITY);
        let moving = |motion: Option<d::Motion>| moves || motion.is_some_and(|motion| motion.moves());
        match object {
            Object::Group(group) => {
                return self.walk(&group.objects, &placed(&group.transform), moving(group.motion));
            }
            Object::Instance(instance) => {
                let Some(objects) = self.description.definitions.get(&instance.of) else { return true };
                if !self.may_hold_lamps(std::slice::from_ref(object)) {
                    return true;
                }
                let Some(left) = self.placed.checked_sub(objects.len()) else { return false };
                self.placed = left;
                return self.walk(objects, &placed(&instance.transform), moving(instance.motion));
            }
            _ => {}
        }
        let Some(material) = self.material_of(object) else { return true };
        if !self.glows[material] {
            return true;
        }
        match forms(object, map).filter(|_| !moves) {
            Some(forms) if self.lamps.len() + forms.len() <= MOST => {
                let radiance = self.radiance[material];
                self.lamps.extend(forms.into_iter().map(|form| Lamp { form, material, radiance }));
                true
            }
            Some(_) => false,
            None => {
                self.glows[material] = false;
                true
            }
        }
    }
}

/// A body as forms of lamps; none if it is of another form.
fn forms(object: &Object, map: &DAffine3) -> Option<Vec<Form>> {
    let at = |point: [f64; 3]| map.transform_point3(DVec3::from_array(point));
    let triangle = |corners: [[f64; 3]; 3]| Form::Triangle(corners.map(at));
    Some(match object {
        Object::Triangle(o) => vec![triangle(o.vertices)],
        Object::Quad(o) => {
            let [a, b, c, d] = o.vertices;
            vec![triangle([a, b, c]), triangle([a, c, d])]
        }
        Object::Disc(o) => {
            let normal = DVec3::from_array(o.normal).normalize_or(DVec3::Y);
            let (u, v) = normal.any_orthonormal_pair();
            let [u, v] = [u, v].map(|axis| map.transform_vector3(axis * o.radius));
            vec![Form::Ellipse { center: at(o.center), axes: [u, v] }]
        }
        Object::Mesh(o) => {
            let corner = |index: u32| o.vertices[index as usize];
            o.faces.iter().map(|face| triangle(face.map(corner))).collect()
        }
        Object::Box(o) => {
            let corner = |i: usize| [0, 1, 2].map(|c| if i >> c & 1 == 0 { o.min[c] } else { o.max[c] });
            let sides = [[0, 1, 3, 2], [4, 5, 7, 6], [0, 1, 5, 4], [2, 3, 7, 6], [0, 2, 6, 4], [1, 3, 7, 5]];
            let halves = |[a, b, c, d]: [usize; 4]| [[a, b, c], [a, c, d]];
            sides.into_iter().flat_map(halves).map(|corners| triangle(corners.map(corner))).collect()
        }
        Object::Sphere(o) => {
            // Those that are placed may be stretched.
            let placed = *map != DAffine3::IDENTITY;
            return (!placed).then(|| vec![Form::Sphere { center: at(o.center), radius: o.radius }]);
        }
        _ => return None,
    })
}
