//! Extensions: which are read, which only change the look and are left out with a warning, and which are refused by name.

use super::super::fault::{Fault, Faults, Kind, Subject, Warning, warn};
use super::json::Document;
use crate::enum_names::list;

/// Unknown extensions that a warning names.
const SHOWN: usize = 5;

/// Read completely, or without any meaning for a picture.
const READ: [&str; 26] = [
    "EXT_mesh_gpu_instancing",
    "EXT_meshopt_compression",
    "EXT_texture_webp",
    "KHR_draco_mesh_compression",
    "KHR_lights_punctual",
    "KHR_materials_clearcoat",
    "KHR_materials_dispersion",
    "KHR_materials_emissive_strength",
    "KHR_materials_ior",
    "KHR_materials_pbrSpecularGlossiness",
    "KHR_materials_specular",
    "KHR_materials_transmission",
    "KHR_materials_unlit",
    "KHR_materials_variants",
    "KHR_materials_volume",
    "KHR_mesh_quantization",
    "KHR_meshopt_compression",
    "KHR_node_visibility",
    "KHR_texture_basisu",
    "KHR_texture_transform",
    "KHR_xmp",
    "KHR_xmp_json_ld",
    "KHR_node_hoverability",
    "KHR_node_selectability",
    "KHR_audio",
    "KHR_interactivity",
];

/// What only changes the look, and is left out: the extension, what warnings call it, and what is missing.
const LOOK: [(&str, &str, &str); 6] = [
    ("KHR_materials_sheen", "sheen", "cloth has no soft rim of light"),
    ("KHR_materials_iridescence", "iridescence", "thin films have no colors"),
    ("KHR_materials_anisotropy", "anisotropy", "brushed metal has round highlights"),
    ("KHR_materials_diffuse_transmission", "diffuse-transmission", "leaves and paper let no light through"),
    ("KHR_materials_volume_scatter", "volume-scatter", "wax and skin do not scatter light inside"),
    ("KHR_animation_pointer", "animation-pointer", "only nodes are animated"),
];

/// Refuses extensions that are required and not read.
pub(super) fn check(document: &Document, strict: bool) -> Result<(), Faults> {
    let mut faults = Faults::default();
    for (i, name) in document.extensions_required.iter().enumerate() {
        let shown: String = name.chars().take(60).collect();
        let detail = match name.as_str() {
            name if READ.contains(&name) => continue,
            name => match LOOK.iter().find(|(known, ..)| *known == name) {
                Some(_) if !strict => continue,
                Some((_, _, missing)) => {
                    format!("it is not simulated ({missing}): leave out strict=true to render all else")
                }
                None => "the extension is not known, and may change how the file is read".to_owned(),
            },
        };
        let detail = format!("the file requires {shown}: {detail}");
        faults.push(Fault::new(format!("/extensionsRequired/{i}"), Kind::Unsupported, detail));
    }
    faults.none_or_err()
}

/// Notes extensions that are not known: what they say is left out.
pub(super) fn note_unknown(warnings: &mut Vec<Warning>, document: &Document) {
    let is_known = |name: &str| READ.contains(&name) || LOOK.iter().any(|(known, ..)| *known == name);
    let unknown: Vec<(usize, &str)> =
        document.extensions_used.iter().map(String::as_str).enumerate().filter(|(_, name)| !is_known(name)).collect();
    if let [(first, _), ..] = unknown[..] {
        let shown = unknown.iter().take(SHOWN).map(|(_, name)| name.chars().take(60).collect());
        let more = if unknown.len() > SHOWN { ", and more" } else { "" };
        let detail = format!("extensions that are not known: {}{more}", list(shown, "and"));
        warn(warnings, Subject::Skipped, "extensions", format!("/extensionsUsed/{first}"), &detail);
    }
}

/// Notes what of a material's extensions is left out.
pub(super) fn note_look(warnings: &mut Vec<Warning>, name: &str, pointer: String) {
    if let Some((_, what, missing)) = LOOK.iter().find(|(known, ..)| *known == name) {
        warn(warnings, Subject::NotSimulated, what, pointer, missing);
    }
}
