//! NFF's fills and objects as materials and bodies.
//!
//! Opaque objects are visible from outside only, transmitting ones from both sides. Faces of one transmitting fill become
//! one mesh, because only a mesh encloses a body that refracts; single polygons are infinitely thin.

use super::entity::{Cone, Fill, Patch, Sphere};
use super::faces::{Faces, triangles};
use super::tokens::Place;
use crate::math::Rgb;
use crate::scene::description::{self, Color, Cylinder, Diffuse, Material, Object, Polygon, Vec3};
use crate::scene::limits::{Limit, OBJECTS, TRIANGLES};
use crate::scene::named::Named;
use crate::scene::problem::{Code, Problem};
use std::collections::HashMap;

/// From this number of triangles on, the faces of an opaque fill become a mesh.
const MESH_TRIANGLES: usize = 3;

/// The material of objects before the first fill.
const DEFAULT_FILL: Fill = Fill { color: [1.0; 3], kd: 0.8, ks: 0.0, shine: 0.0, transmittance: 0.0, ior: 1.0 };

/// The materials and bodies so far.
#[derive(Debug)]
pub(super) struct Bodies {
    two_sided: bool,
    materials: Named<Material>,
    /// Names of the fills seen, by the bits of their numbers.
    names: HashMap<[u64; 8], String>,
    fill: Fill,
    /// Its name, once it has an object.
    name: Option<String>,
    objects: Vec<Object>,
    /// Triangles read, for the limit.
    triangles: u64,
    /// Faces of the current fill, to become one mesh.
    flat: Faces,
    smooth: Faces,
}

impl Bodies {
    pub(super) fn new(two_sided: bool) -> Self {
        Self {
            two_sided,
            materials: Named::default(),
            names: HashMap::new(),
            fill: DEFAULT_FILL,
            name: None,
            objects: Vec::new(),
            triangles: 0,
            flat: Faces::default(),
            smooth: Faces::default(),
        }
    }

    pub(super) fn finish(mut self) -> (Named<Material>, Vec<Object>) {
        self.flush();
        (self.materials, self.objects)
    }

    /// Some files repeat the fill before each object; a repeated fill changes nothing.
    pub(super) fn fill(&mut self, fill: Fill) {
        if fill != self.fill {
            self.flush();
            self.fill = fill;
            self.name = None;
        }
    }

    /// A negative radius makes the inside visible.
    pub(super) fn sphere(&mut self, place: Place, sphere: Sphere) -> Result<(), Problem> {
        if sphere.radius == 0.0 {
            return Err(place.problem(Code::Degenerate, "the sphere's radius is 0"));
        }
        let material = self.material();
        let (radius, hollow) = (sphere.radius.abs(), sphere.radius < 0.0);
        let body = description::Sphere { center: sphere.center, radius, material, name: None, hollow };
        self.push(place, Object::Sphere(body))
    }

    /// Open at both ends. Negative radii make the inside visible.
    pub(super) fn cone(&mut self, place: Place, cone: &Cone) -> Result<(), Problem> {
        let degenerate = |detail: &str| Err(place.problem(Code::Degenerate, detail));
        let radii = [cone.base_radius, cone.apex_radius];
        if cone.base == cone.apex {
            return degenerate("the cone's base and apex are the same point");
        }
        if radii == [0.0; 2] {
            return degenerate("both radii of the cone are 0");
        }
        let hollow = radii.iter().any(|radius| *radius < 0.0);
        if hollow && radii.iter().any(|radius| *radius > 0.0) {
            return degenerate("one radius of the cone is negative; to make its inside visible both must be");
        }
        let (base, top, material) = (cone.base, cone.apex, self.material());
        let [base_radius, top_radius] = radii.map(f64::abs);
        let object = if base_radius == top_radius {
            Object::Cylinder(Cylinder { base, top, radius: base_radius, capped: false, material, name: None, hollow })
        } else {
            let (capped, name) = (false, None);
            Object::Cone(description::Cone { base, base_radius, top, top_radius, capped, material, name, hollow })
        };
        self.push(place, object)
    }

    pub(super) fn polygon(&mut self, place: Place, mut vertices: Vec<Vec3>) -> Result<(), Problem> {
        let cut = triangles(place, &mut vertices, &mut [])?;
        self.count(place, cut.len())?;
        if vertices.len() == 3 || self.transmits() {
            self.flat.add(&vertices, &[], &cut);
            return Ok(());
        }
        let material = self.material();
        self.push(place, Object::Polygon(Polygon { vertices, material, name: None }))
    }

    pub(super) fn patch(&mut self, place: Place, mut patch: Patch) -> Result<(), Problem> {
        let cut = triangles(place, &mut patch.vertices, &mut patch.normals)?;
        self.count(place, cut.len())?;
        self.smooth.add(&patch.vertices, &patch.normals, &cut);
        Ok(())
    }

    fn transmits(&self) -> bool {
        self.fill.transmittance > 0.0
    }

    /// Makes bodies of the collected faces. Their number was checked when they were read.
    fn flush(&mut self) {
        let (flat, smooth) = (std::mem::take(&mut self.flat), std::mem::take(&mut self.smooth));
        if flat.len() >= MESH_TRIANGLES || (self.transmits() && flat.len() > 0) {
            let mesh = flat.into_mesh(self.material());
            self.objects.push(Object::Mesh(Box::new(mesh)));
        } else {
            for triangle in flat.into_triangles() {
                let material = self.material();
                let body = description::Triangle { vertices: triangle, material, name: None };
                self.objects.push(Object::Triangle(body));
            }
        }
        if smooth.len() > 0 {
            let mesh = smooth.into_mesh(self.material());
            self.objects.push(Object::Mesh(Box::new(mesh)));
        }
    }

    fn push(&mut self, place: Place, object: Object) -> Result<(), Problem> {
        within(OBJECTS, self.objects.len() as u64 + 1, place)?;
        self.objects.push(object);
        Ok(())
    }

    fn count(&mut self, place: Place, triangles: usize) -> Result<(), Problem> {
        self.triangles += triangles as u64;
        within(TRIANGLES, self.triangles, place)
    }

    /// The name of the current fill's material, which is made with its first object.
    fn material(&mut self) -> Option<String> {
        if self.name.is_none() {
            self.name = Some(self.named_material());
        }
        self.name.clone()
    }

    fn named_material(&mut self) -> String {
        let Fill { color: [r, g, b], kd, ks, shine, transmittance, ior } = self.fill;
        let bits = [r, g, b, kd, ks, shine, transmittance, ior].map(f64::to_bits);
        if let Some(name) = self.names.get(&bits) {
            return name.clone();
        }
        let name = format!("fill_{}", self.names.len() + 1);
        self.materials.insert(name.clone(), material(&self.fill, self.two_sided));
        self.names.insert(bits, name.clone());
        name
    }
}

fn material(fill: &Fill, two_sided: bool) -> Material {
    let transmits = fill.transmittance > 0.0;
    let grey = |weight: f64| Color(Rgb::splat(weight));
    Material {
        ambient: None,
        diffuse: Diffuse::Uniform(Color(fill.kd * Rgb::from_array(fill.color))),
        specular: grey(fill.ks),
        shininess: fill.shine,
        reflection: grey(fill.ks),
        transmission: grey(fill.transmittance),
        ior: if (0.01..=100.0).contains(&fill.ior) { fill.ior } else { 1.0 },
        one_sided: !two_sided && !transmits,
        ..Material::default()
    }
}

fn within(limit: Limit, count: u64, place: Place) -> Result<(), Problem> {
    if count <= limit.max {
        return Ok(());
    }
    Err(place.problem(Code::Limit, format!("the file has more {} than the limit of {}", limit.name, limit.max)))
}
