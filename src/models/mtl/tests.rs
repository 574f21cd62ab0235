//! Materials of MTL: what each key becomes, what is left out, and what is wrong.

use super::super::fault::Place;
use super::super::parts::exact_or_plain;
use super::*;

fn read(mtl: &str) -> (Vec<ModelMaterial>, Model) {
    let (mut library, mut model) = (Library::default(), Model::default());
    let parts = |name: &str| match name {
        "textures/my wood.png" => Ok(b"\x89PNG\r\n\x1a\n".to_vec()),
        _ => Err("is not there".to_owned()),
    };
    let parts = |name: &str| exact_or_plain(name, parts);
    let read = library.read("a.mtl", mtl.as_bytes(), &parts, &mut model, &Budget::default());
    read.unwrap_or_else(|fault| panic!("{fault:?}"));
    (library.materials, model)
}

#[test]
fn pictures_are_found_however_their_names_are_written() {
    for line in [
        "map_Kd textures/my wood.png",
        "Map_Kd -s 2 2 2 -o 0 0 0 textures\\my wood.png",
        "MAP_KD .\\textures\\\\my wood.png",
        "map_kd ./textures//my%20wood.png",
    ] {
        let (materials, model) = read(&format!("NewMtl a\r\n\t{line}  \r\n"));
        assert!(materials[0].base_color.texture.is_some() && model.warnings.is_empty(), "{line}: {model:?}");
    }
    for line in ["..\\textures\\my wood.png", "/textures/my wood.png", "C:\\textures\\my wood.png"] {
        let (materials, model) = read(&format!("newmtl a\nmap_Kd {line}\n"));
        assert!(materials[0].base_color.texture.is_none() && model.warnings.len() == 1, "{line}: {model:?}");
    }
    let (_, model) = read("newmtl a\nmap_Bump -bm 0.5 textures\\my wood.png\n");
    assert_eq!(model.warnings[0].what, "bump");
}

/// Under ever other names, and though it is no picture.
#[test]
fn files_that_are_read_again_and_again_are_bounded() {
    let (mut library, mut model) = (Library::default(), Model::default());
    let parts = |_: &str| Ok(vec![0; 32 << 20]);
    let mtl: String = (0..100).map(|i| format!("newmtl {i}\nmap_Kd {i}\n")).collect();
    let fault = library.read("a.mtl", mtl.as_bytes(), &parts, &mut model, &Budget::default()).unwrap_err();
    assert_eq!(fault.kind, Kind::Limit);
    assert_eq!(library.materials.len(), 33, "1 GiB");
}

/// Where they are written, not where the scene has them.
#[test]
fn transforms_beyond_all_numbers_are_refused_in_their_line() {
    let refused = |options: &str| {
        let mtl = format!("newmtl a\n\tmap_Kd {options} textures/my wood.png\n");
        let (mut library, mut model) = (Library::default(), Model::default());
        let fault = library.read("a.mtl", mtl.as_bytes(), &|_| Err("".into()), &mut model, &Budget::default()).err();
        fault.map(|fault| (fault.kind, fault.place, fault.detail.starts_with("a.mtl: the scale and the offset")))
    };
    for options in ["-s 1e300", "-s 1 -1e16", "-o 1e300", "-o 9e14 9e14 -s 1 9e14"] {
        assert_eq!(refused(options), Some((Kind::OutOfRange, Place::Line(2, 2), true)), "{options}");
    }
    assert_eq!(refused("-s 1e14 1e14 -o -1e14"), None);
}

#[test]
fn pictures_that_stand_alone_are_the_values() {
    let wood = "textures/my wood.png";
    let (alone, _) = read(&format!("newmtl a\nmap_Kd {wood}\nmap_Pr {wood}\nmap_Pm {wood}\nmap_Ke {wood}\n"));
    let ModelMaterial { base_color, roughness, metallic, emissive, .. } = &alone[0];
    assert_eq!((base_color.factor, roughness.factor, metallic.factor, emissive.factor), ([1.0; 3], 1.0, 1.0, [1.0; 3]));
    let (with, _) =
        read(&format!("newmtl a\nmap_Kd {wood}\nKd 0.5 0.5 0.5\nmap_Pr {wood}\nPr 0.2\nmap_Pm {wood}\nPm 0.3\n"));
    let ModelMaterial { base_color, roughness, metallic, .. } = &with[0];
    assert_eq!((base_color.factor, roughness.factor, metallic.factor), ([0.5; 3], 0.2, 0.3));
    let (beside, _) = read(&format!("newmtl a\nNs 250\nmap_Pr {wood}\nmap_Ke {wood}\nKe 0 0 0\n"));
    assert_eq!((beside[0].roughness.factor, beside[0].emissive.factor), (1.0, [0.0; 3]));
    assert_eq!(read("newmtl a\nmap_Ke gone.png\n").0[0].emissive.factor, [0.0; 3]);
    let (none, _) = read("newmtl a\n");
    assert_eq!((none[0].base_color.factor, none[0].roughness.factor, none[0].metallic.factor), ([0.8; 3], 0.5, 0.0));
}

#[test]
fn keys_are_read_or_named() {
    let what = |lines: &str| -> Vec<&str> {
        read(&format!("newmtl a\n{lines}\n")).1.warnings.iter().map(|warning| warning.what).collect()
    };
    for (lines, expected) in [
        ("Ka 1 1 1\nKm 0.1\nPs 0\naniso 0\nmap_Ka textures/my wood.png", &[][..]),
        ("Ps 0.5", &["sheen"]),
        ("aniso 0.5", &["anisotropy"]),
        ("map_Ks textures/my wood.png", &["texture-keys"]),
        ("map_Ks gone.png\nmap_Kd gone.png", &["texture-keys", "textures"]),
        ("map_Kd -imfchan r textures/my wood.png", &["texture-options"]),
        ("Kd spectral a.rfl 1", &["color-spectra"]),
        ("map_d textures/my wood.png", &["opacity-map"]),
        ("map_d textures/my wood.png\nmap_Kd textures/my wood.png", &[]),
    ] {
        assert_eq!(what(lines), expected, "{lines}");
    }
    let (coated, _) = read("newmtl a\nPc 0.7\nPcr 0.2\n");
    let coat = coated[0].clearcoat.unwrap();
    assert_eq!((coat.factor.factor, coat.roughness.factor), (0.7, 0.2));
    let of = |lines: &str| read(&format!("newmtl a\n{lines}\n")).0.remove(0);
    assert_eq!((of("illum 1").specular.factor, of("illum 2").specular.factor), (0.0, 1.0));
    assert_eq!(of("illum 1\nPr 0.2").specular.factor, 1.0);
    let plastic = of("Ks 0.5 0.25 0.05\nNi 1\nillum 2");
    assert_eq!((plastic.specular_color.factor, plastic.ior), ([1.0, 0.5, 0.1], 1.5));
    let mirror = of("Ks 1 0.5 0\nillum 3");
    assert!((0..3).all(|c| (mirror.specular_color.factor[c] * 0.04 - [1.0, 0.5, 0.0][c]).abs() < 1e-12), "{mirror:?}");
    assert_eq!((mirror.roughness.factor, of("Ks 1 1 1\nillum 3\nNs 6").roughness.factor), (0.0, 0.5_f64.sqrt()));
    assert_eq!(of("Ks 1 1 1\nillum 6\nd 0.1\nNi 1.5").specular_color.factor, [1.0; 3]);
    assert_eq!(of("map_d textures/my wood.png\nmap_Kd textures/my wood.png").alpha, Alpha::Blend);
}

#[test]
fn of_two_opacities_d_counts() {
    for (lines, opacity) in
        [("d 0.25\nTr 1", 0.25), ("Tr 1\nd 0.25", 0.25), ("Tr 0.25", 0.75), ("TR 0.25", 0.75), ("d -halo 0.5", 0.5)]
    {
        assert_eq!(read(&format!("newmtl a\n{lines}\n")).0[0].opacity, opacity, "{lines}");
    }
}

#[test]
fn numbers_out_of_range_are_told() {
    for (line, told) in [
        ("Kd -1 0 0", "-1 of \"Kd\" as 0"),
        ("d 2", "2 of \"d\" as 1"),
        ("Pr 3", "3 of \"Pr\" as 1"),
        ("Ni 0.5", "0.5 of \"Ni\" as 1"),
    ] {
        let (_, model) = read(&format!("newmtl a\n{line}\n"));
        assert!(model.warnings[0].detail.ends_with(told), "{:?}", model.warnings);
    }
    assert!(read("newmtl a\nKd 1 0 0\nd 1.0000001\nNs 0\nNi 0\n").1.warnings.is_empty());
}
