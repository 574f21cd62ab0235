//! What OBJ files become.

use super::*;

fn read_with(obj: &str, files: &[(&str, &str)]) -> Model {
    let part = |name: &str| {
        let file = files.iter().find(|(known, _)| *known == name);
        file.map(|(_, bytes)| bytes.as_bytes().to_vec()).ok_or_else(|| "is not there".to_owned())
    };
    read(obj.as_bytes(), &part).unwrap_or_else(|faults| panic!("{faults:?}"))
}

/// The red of the materials that are used, in their order.
fn reds(model: &Model) -> Vec<f64> {
    model.placements.iter().map(|placed| model.materials[placed.material.unwrap()].base_color.factor[0]).collect()
}

#[test]
fn several_libraries_may_have_spaces_in_their_names() {
    let files = [
        ("my first.mtl", "newmtl one a\nKd 0.1 0 0"),
        ("b.MTL", "newmtl two\nKd 0.2 0 0"),
        ("c", "newmtl three\nKd 0.3 0 0"),
    ];
    let faces = "v 0 0 0\nv 1 0 0\nv 0 1 0\nusemtl one a\nf 1 2 3\nusemtl two\nf 1 2 3\nusemtl three\nf 1 2 3\n";
    for line in ["my first.mtl b.MTL c", "b.MTL  my first.mtl\tc", "b.MTL \\\r\n my first.mtl c"] {
        let model = read_with(&format!("mtllib {line}\n{faces}"), &files);
        assert_eq!((reds(&model), model.warnings.len()), (vec![0.1, 0.2, 0.3], 0), "{line}");
    }
    // One that is missing takes none of the others with it.
    let model = read_with(&format!("mtllib my first.mtl no such.mtl b.MTL c\n{faces}"), &files);
    assert_eq!(reds(&model), [0.1, 0.2, 0.3]);
    assert!(model.warnings[0].detail.ends_with("\"no such.mtl\" is not there"), "{:?}", model.warnings);
}

/// However often they are named.
#[test]
fn libraries_are_read_once_and_few() {
    let asked = std::cell::Cell::new(0);
    let part = |name: &str| {
        asked.set(asked.get() + 1);
        if name == "a" { Ok(b"newmtl a\n".to_vec()) } else { Err("is not there".to_owned()) }
    };
    let triangle = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";
    let again = format!("mtllib{}\n{}{triangle}", " a b".repeat(1_000), "mtllib a\nmtllib b\n".repeat(1_000));
    assert_eq!(read(again.as_bytes(), &part).unwrap().warnings.len(), 1);
    assert_eq!(asked.get(), 3, "the whole line, a and b");
    let many: String = (0..5_000).map(|i| format!("mtllib {i}\n")).collect();
    let Faults(faults) = read((many + triangle).as_bytes(), &part).unwrap_err();
    assert!(faults.len() == 1 && faults[0].kind == Kind::Limit, "{faults:?}");
    assert!(asked.get() < 3_000, "{} files were asked for", asked.get());
}

/// Normals of each triangle's corners; none where its part has none.
fn normals(model: &Model) -> Vec<Option<Vec<[f64; 3]>>> {
    let mut all = Vec::new();
    for geometry in &model.geometries {
        let of = |triangle: &[u32; 3]| {
            let normals = geometry.normals.as_ref()?;
            Some(triangle.iter().map(|i| normals[*i as usize]).collect())
        };
        all.extend(geometry.triangles.iter().map(of));
    }
    all
}

/// Two faces that meet at 30 degrees.
const BENT: &str = "v -1 0 0\nv 0 0 1\nv 0 0 0\nv 0.866 0.5 0\n";

#[test]
fn smoothing_holds_for_the_faces_behind_its_statement() {
    let leans = |faces: &str| {
        let model = read_with(&format!("{BENT}{faces}"), &[]);
        let of = |normals: &Option<Vec<[f64; 3]>>| {
            normals.as_ref().is_some_and(|normals| normals.windows(2).any(|pair| pair[0] != pair[1]))
        };
        normals(&model).iter().map(of).collect::<Vec<_>>()
    };
    for (faces, expected) in [
        ("f 1 2 3\nf 3 2 4\n", [true, true]),
        ("s 1\nf 1 2 3\nf 3 2 4\ns off\n", [true, true]),
        ("s on\nf 1 2 3\nf 3 2 4\n", [true, true]),
        ("s off\nf 1 2 3\nf 3 2 4\ns 1\n", [false, false]),
        ("s 1\nf 1 2 3\ns 0\nf 3 2 4\n", [false, false]),
        ("s 1\nf 1 2 3\ns 2\nf 3 2 4\n", [false, false]),
        ("usemtl a\nf 1 2 3\nusemtl b\nf 3 2 4\n", [true, true]),
    ] {
        assert_eq!(leans(faces), expected, "{faces}");
    }
}

/// A normal of one face is none of another.
#[test]
fn faces_without_normals_are_as_if_no_other_had_any() {
    let cube = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 0 0 1\nf 4 3 2 1\nf 1 2 5\nf 1 5 4\n";
    let alone = normals(&read_with(cube, &[]));
    assert!(alone.iter().all(Option::is_none), "its edges are sharp");
    let beside =
        normals(&read_with(&format!("{cube}v 5 0 0\nv 6 0 0\nv 5 1 0\nvn 0 0.6 0.8\nf 6//1 7//1 8//1\n"), &[]));
    let (given, flat) = beside.split_last().unwrap();
    assert_eq!(given.as_ref().unwrap(), &vec![[0.0, 0.6, 0.8]; 3]);
    for (triangle, normals) in flat.iter().enumerate() {
        let normals = normals.as_ref().unwrap();
        assert!(normals.iter().all(|normal| *normal == normals[0]), "{triangle}: {normals:?}");
    }
}

#[test]
fn comments_may_stand_behind_names() {
    let files = [("a.mtl", "newmtl one\nKd 0.1 0 0\nnewmtl two #2\nKd 0.2 0 0")];
    let faces = "v 0 0 0\nv 1 0 0\nv 0 1 0\nusemtl one # the first\nf 1 2 3\nusemtl two #2\nf 1 2 3\n";
    let model = read_with(&format!("mtllib a.mtl # all\n{faces}"), &files);
    assert_eq!((reds(&model), model.warnings.len()), (vec![0.1, 0.2], 0), "{:?}", model.warnings);
}

#[test]
fn lines_are_as_programs_write_them() {
    let obj = "\u{feff}# a\r\nv\t0 0 0\r\nv 1 0 0 1\r\nv 0 1 0\r\nv 1 1 0\r\nvn 0 0 1 0\r\nvt 0 0 0\r\n\
        f 1// 2// 3//\r\nf 2/1/1\\\r\n -1/-1/-1 \\\r\n\t3/1/1\r\n";
    assert_eq!(read_with(obj, &[]).triangles(), 2);
}
