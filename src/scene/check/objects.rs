//! Checks of objects and definitions: geometry, references, cycles, and limits on their number.

use super::findings::Findings;
use super::materials::check_material;
use super::path::Path;
use crate::scene::description::{Appearance, Description, Material, Mesh, Motion, Object, Transform, Vec3};
use crate::scene::limits;
use crate::scene::problem::{Code, quoted};
use crate::scene::transform::affine;
use crate::shape::ear_clipping::triangulate;
use crate::shape::is_collapsed;
use glam::DVec3;

/// Checks all objects and definitions.
pub(super) fn check_objects(findings: &mut Findings, description: &Description) {
    let root = Path::ROOT;
    let mut counter = Counter { findings, description, objects: 0, triangles: 0, polygon_work: 0 };
    if description.objects.is_empty() {
        let detail = "is empty: a scene needs at least one object";
        counter.findings.add(root.key("objects"), Code::Degenerate, detail);
    }
    counter.list(root.key("objects"), &description.objects);
    for (name, objects) in description.definitions.iter() {
        if counter.findings.name(root.key("definitions").key(name), name) {
            counter.list(root.key("definitions").key(name), objects);
        }
    }
    let Counter { objects, triangles, polygon_work, .. } = counter;
    findings.count(root.key("objects"), "objects", objects, limits::OBJECTS);
    findings.count(root.key("objects"), "triangles", triangles, limits::TRIANGLES);
    findings.count(root.key("objects"), "squared corners of polygons", polygon_work, limits::POLYGON_WORK);
    check_nesting(findings, description);
}

struct Counter<'a> {
    findings: &'a mut Findings,
    description: &'a Description,
    objects: u64,
    triangles: u64,
    polygon_work: u64,
}

impl Counter<'_> {
    fn list(&mut self, at: Path<'_>, objects: &[Object]) {
        for (i, object) in objects.iter().enumerate() {
            if self.findings.full() {
                return;
            }
            self.objects += 1;
            let at = at.index(i);
            self.object(at.key(object.kind()), object);
        }
    }

    fn object(&mut self, at: Path<'_>, object: &Object) {
        let f = &mut *self.findings;
        let appearance = match object {
            Object::Sphere(o) => {
                f.point(at.key("center"), &o.center);
                f.length(at.key("radius"), o.radius);
                o.appearance()
            }
            Object::Plane(o) => {
                f.point(at.key("point"), &o.point);
                f.direction(at.key("normal"), &o.normal);
                o.appearance()
            }
            Object::Disc(o) => {
                f.point(at.key("center"), &o.center);
                f.direction(at.key("normal"), &o.normal);
                f.length(at.key("radius"), o.radius);
                o.appearance()
            }
            Object::Triangle(o) => {
                self.triangles += 1;
                flat_points(f, at, &o.vertices, "triangle");
                o.appearance()
            }
            Object::Quad(o) => {
                self.triangles += 2;
                flat_points(f, at, &o.vertices, "quad");
                o.appearance()
            }
            Object::Box(o) => {
                let sound = f.point(at.key("min"), &o.min) & f.point(at.key("max"), &o.max);
                let sizes: Vec3 = std::array::from_fn(|i| o.max[i] - o.min[i]);
                if sound && sizes.iter().any(|s| *s < 0.0) {
                    f.add(at.key("max"), Code::OutOfRange, "must not be below min in any coordinate");
                } else if sound && sizes.iter().filter(|s| **s == 0.0).count() > 1 {
                    f.add(
                        at.key("max"),
                        Code::Degenerate,
                        "equals min in more than one coordinate: the box has no area",
                    );
                }
                o.appearance()
            }
            Object::Cylinder(o) => {
                axis(f, at, &o.base, &o.top);
                f.length(at.key("radius"), o.radius);
                o.appearance()
            }
            Object::Cone(o) => {
                axis(f, at, &o.base, &o.top);
                for (key, radius) in [("base_radius", o.base_radius), ("top_radius", o.top_radius)] {
                    if radius != 0.0 {
                        f.length(at.key(key), radius);
                    }
                }
                if o.base_radius == 0.0 && o.top_radius == 0.0 {
                    f.add(at.key("base_radius"), Code::Degenerate, "and top_radius must not both be 0");
                }
                o.appearance()
            }
            Object::Torus(o) => {
                f.point(at.key("center"), &o.center);
                f.direction(at.key("axis"), &o.axis);
                f.length(at.key("major_radius"), o.major_radius);
                f.length(at.key("minor_radius"), o.minor_radius);
                if o.minor_radius >= o.major_radius {
                    let detail = format!("must be below major_radius, {}, is {}", o.major_radius, o.minor_radius);
                    f.add(at.key("minor_radius"), Code::OutOfRange, detail);
                }
                o.appearance()
            }
            Object::Mesh(o) => {
                self.triangles += o.faces.len() as u64;
                check_mesh(f, at, o);
                o.appearance()
            }
            Object::Polygon(o) => {
                self.triangles += o.vertices.len().saturating_sub(2) as u64;
                self.polygon_work = self.polygon_work.saturating_add((o.vertices.len() as u64).saturating_pow(2));
                if self.polygon_work <= limits::POLYGON_WORK.max {
                    check_polygon(f, at, &o.vertices);
                }
                o.appearance()
            }
            Object::Group(o) => {
                check_placement(f, at, &o.transform, o.motion, o.name.as_deref());
                self.list(at.key("objects"), &o.objects);
                return;
            }
            Object::Model(o) => {
                check_placement(f, at, &o.transform, o.motion, o.name.as_deref());
                f.name(at.key("asset"), &o.asset);
                for (name, material) in &o.materials {
                    if f.name(at.key("materials").key(name), name) {
                        check_material(f, at.key("materials").key(name), material);
                    }
                }
                return;
            }
            Object::Instance(o) => {
                check_placement(f, at, &o.transform, o.motion, o.name.as_deref());
                if f.name(at.key("of"), &o.of) && self.description.definitions.get(&o.of).is_none() {
                    let hint = f.suggestion(&o.of, self.description.definitions.keys());
                    f.add(at.key("of"), Code::UnknownReference, format!("no definition {}{hint}", quoted(&o.of)));
                }
                return;
            }
        };
        let sets = match object {
            Object::Mesh(mesh) => [mesh.uvs.is_some(), mesh.uvs1.is_some()],
            _ => [false; 2],
        };
        self.material(at, appearance, sets);
    }

    /// `sets`: which texture coordinates the object has.
    fn material(&mut self, at: Path<'_>, appearance: Appearance<'_>, sets: [bool; 2]) {
        if let Some(name) = appearance.name {
            self.findings.name(at.key("name"), name);
        }
        let Some(name) = appearance.material else { return };
        if !self.findings.name(at.key("material"), name) {
            return;
        }
        let material = self.description.materials.get(name);
        let needed = material.map_or([false; 2], Material::uv_sets);
        for (key, needs, has) in [("uvs", needed[0], sets[0]), ("uvs1", needed[1], sets[1])] {
            if needs && !has {
                let detail = format!(
                    "the material {} lays a picture by {key}, which there are none of: give a mesh \"{key}\", or the \
                     picture another mapping",
                    quoted(name)
                );
                self.findings.add(at.key("material"), Code::MissingKey, detail);
            }
        }
        if material.is_none() {
            let hint = self.findings.suggestion(name, self.description.materials.keys());
            let detail = format!("no material {}{hint}", quoted(name));
            self.findings.add(at.key("material"), Code::UnknownReference, detail);
        }
    }
}

fn check_placement(
    findings: &mut Findings,
    at: Path<'_>,
    transform: &Transform,
    motion: Option<Motion>,
    name: Option<&str>,
) {
    if let Err(detail) = affine(transform) {
        findings.add(at.key("transform"), Code::Degenerate, detail);
    }
    if let Some(name) = name {
        findings.name(at.key("name"), name);
    }
    let Some(motion) = motion else { return };
    let at = at.key("motion");
    for (key, point) in [("translate", motion.translate), ("center", motion.center)] {
        if let Some(point) = point {
            findings.point(at.key(key), &point);
        }
    }
    if let Some(rotation) = motion.rotate_deg {
        let at = at.key("rotate_deg");
        findings.direction(at.key("axis"), &rotation.axis);
        let (angle, max) = (rotation.angle, limits::ROTATION);
        findings.number(at.key("angle"), angle, format_args!("between -{max} and {max}"), angle.abs() <= max);
    }
}

fn axis(findings: &mut Findings, at: Path<'_>, base: &Vec3, top: &Vec3) {
    let sound = findings.point(at.key("base"), base) & findings.point(at.key("top"), top);
    let length = DVec3::from_array(*top).distance(DVec3::from_array(*base));
    if sound && length < limits::SMALLEST_LENGTH {
        findings.add(at.key("top"), Code::Degenerate, "must not be the point base: the axis has no direction");
    }
}

fn flat_points(findings: &mut Findings, at: Path<'_>, vertices: &[Vec3], what: &str) {
    let list = at.key("vertices");
    let mut sound = true;
    for (i, vertex) in vertices.iter().enumerate() {
        sound &= findings.point(list.index(i), vertex);
    }
    let corner = |i: usize| DVec3::from_array(vertices[i]);
    let area = |a: usize, b: usize, c: usize| (corner(b) - corner(a)).cross(corner(c) - corner(a));
    let area = if vertices.len() == 3 { area(0, 1, 2) } else { area(0, 1, 2).abs() + area(0, 2, 3).abs() };
    if sound && area == DVec3::ZERO {
        findings.add(list, Code::Degenerate, format!("the {what} has no area: its corners lie on a line"));
    }
}

fn check_polygon(findings: &mut Findings, at: Path<'_>, vertices: &[Vec3]) {
    let list = at.key("vertices");
    if vertices.len() < 3 {
        let detail = format!("a polygon needs at least 3 corners, has {}", vertices.len());
        findings.add(list, Code::OutOfRange, detail);
        return;
    }
    findings.count(list, "corners", vertices.len() as u64, limits::POLYGON_VERTICES);
    let mut sound = vertices.len() as u64 <= limits::POLYGON_VERTICES.max;
    for (i, vertex) in vertices.iter().enumerate() {
        sound &= findings.point(list.index(i), vertex);
    }
    if !sound {
        return;
    }
    if let Some(i) = first_out_of_plane(vertices) {
        let detail = "does not lie in the plane of the others: use a mesh for surfaces that are not flat";
        findings.add(list.index(i), Code::Degenerate, detail);
    } else if triangulate(vertices).is_none() {
        findings.add(list, Code::Degenerate, "the polygon has no area, or its edges cross");
    }
}

/// The corner farthest from the polygon's plane, if that is more than a thousandth of its size.
fn first_out_of_plane(vertices: &[Vec3]) -> Option<usize> {
    let points: Vec<DVec3> = vertices.iter().map(|v| DVec3::from_array(*v)).collect();
    let origin = points[0];
    let next = points.iter().skip(1).chain([&points[0]]);
    let normal: DVec3 = points.iter().zip(next).map(|(a, b)| (*a - origin).cross(*b - origin)).sum();
    let normal = normal.try_normalize()?;
    let size = points.iter().map(|p| p.distance(origin)).fold(0.0, f64::max);
    let (worst, off) =
        points.iter().map(|p| (*p - origin).dot(normal).abs()).enumerate().max_by(|a, b| a.1.total_cmp(&b.1))?;
    (off > 1e-3 * size).then_some(worst)
}

fn check_mesh(findings: &mut Findings, at: Path<'_>, mesh: &Mesh) {
    let count = mesh.vertices.len();
    if mesh.faces.is_empty() {
        findings.add(at.key("faces"), Code::Degenerate, "is empty: a mesh needs at least one face");
    }
    if let Some((i, vertex)) =
        mesh.vertices.iter().enumerate().find(|(_, v)| v.iter().any(|x| x.is_nan() || x.abs() > limits::MAGNITUDE))
    {
        findings.point(at.key("vertices").index(i), vertex);
    }
    let is_line = |face: &[u32; 3]| is_collapsed(&face.map(|i| mesh.vertices[i as usize]));
    let stray = |face: &[u32; 3]| face.iter().position(|v| *v as usize >= count);
    if let Some((i, k)) = mesh.faces.iter().enumerate().find_map(|(i, face)| stray(face).map(|k| (i, k))) {
        let detail = format!("no vertex {}: the mesh has {count}, counted from 0", mesh.faces[i][k]);
        findings.add(at.key("faces").index(i).index(k), Code::UnknownReference, detail);
    } else if !mesh.faces.is_empty() && mesh.faces.iter().all(is_line) {
        findings.add(at.key("faces"), Code::Degenerate, "no face has an area");
    }
    if let Some(normals) = &mesh.normals {
        if normals.len() != count {
            let detail = format!("must have one normal for each of the {count} vertices, has {}", normals.len());
            findings.add(at.key("normals"), Code::OutOfRange, detail);
        }
        if let Some((i, normal)) = normals
            .iter()
            .enumerate()
            .find(|(_, n)| n.iter().any(|x| x.is_nan() || x.abs() > limits::MAGNITUDE) || n.iter().all(|x| *x == 0.0))
        {
            findings.direction(at.key("normals").index(i), normal);
        }
    }
    let max = limits::MAGNITUDE;
    for (key, uvs) in [("uvs", &mesh.uvs), ("uvs1", &mesh.uvs1)] {
        let Some(uvs) = uvs else { continue };
        let pairs = format!("one pair for each of the {count} vertices");
        numbers(findings, at.key(key), uvs, count, &pairs, (-max, max, &format!("between -{max:e} and {max:e}")));
    }
    if let Some(tangents) = &mesh.tangents {
        let of_each = format!("one tangent for each of the {count} vertices");
        numbers(findings, at.key("tangents"), tangents, count, &of_each, (-1.0, 1.0, "between -1 and 1"));
    }
    if let Some(colors) = &mesh.colors {
        let of_each = format!("one color for each of the {count} vertices");
        numbers(findings, at.key("colors"), colors, count, &of_each, (0.0, 1.0, "between 0 and 1"));
    }
}

/// Checks numbers of vertices: that there are as many, and their range.
fn numbers<const N: usize>(
    findings: &mut Findings,
    at: Path<'_>,
    list: &[[f64; N]],
    count: usize,
    of_each: &str,
    (least, most, range): (f64, f64, &str),
) {
    if list.len() != count {
        findings.add(at, Code::OutOfRange, format!("must have {of_each}, has {}", list.len()));
    }
    let stray = |numbers: &[f64; N]| numbers.iter().position(|x| !(least..=most).contains(x));
    if let Some((i, k)) = list.iter().enumerate().find_map(|(i, numbers)| Some((i, stray(numbers)?))) {
        findings.number(at.index(i).index(k), list[i][k], range, false);
    }
}

/// Cycles among definitions, and the longest chain of groups and instances.
fn check_nesting(findings: &mut Findings, description: &Description) {
    let mut nesting = Nesting { findings, description, depths: vec![Depth::Unknown; description.definitions.len()] };
    for position in 0..description.definitions.len() {
        nesting.of_definition(position, 0);
    }
    let deepest = nesting.of_list(&description.objects, 0);
    findings.count(Path::ROOT.key("objects"), "levels of groups and instances", deepest, limits::NESTING);
}

struct Nesting<'a> {
    findings: &'a mut Findings,
    description: &'a Description,
    depths: Vec<Depth>,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Depth {
    Unknown,
    Open,
    Known(u64),
}

impl Nesting<'_> {
    /// Levels below a definition. Chains are followed only as far as the limit needs.
    fn of_definition(&mut self, position: usize, level: u64) -> u64 {
        let (name, objects) = self.description.definitions.get_index(position).expect("the position of a definition");
        match self.depths[position] {
            Depth::Known(depth) => return depth,
            Depth::Open => {
                let name_shown = quoted(name);
                let detail =
                    format!("the definition {name_shown} uses itself, directly or through others: remove the cycle");
                self.findings.add(Path::ROOT.key("definitions").key(name), Code::Cycle, detail);
                return 0;
            }
            Depth::Unknown if level > limits::NESTING.max => return limits::NESTING.max + 1,
            Depth::Unknown => {}
        }
        self.depths[position] = Depth::Open;
        let depth = self.of_list(objects, level);
        self.depths[position] = Depth::Known(depth);
        depth
    }

    fn of_list(&mut self, objects: &[Object], level: u64) -> u64 {
        let below = |nesting: &mut Self, object: &Object| match object {
            Object::Group(group) => 1 + nesting.of_list(&group.objects, level + 1),
            Object::Instance(instance) => match nesting.description.definitions.get_index_of(&instance.of) {
                Some(position) => 1 + nesting.of_definition(position, level + 1),
                None => 0,
            },
            _ => 0,
        };
        objects.iter().map(|object| below(self, object)).max().unwrap_or(0)
    }
}
