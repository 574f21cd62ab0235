//! What must hold before a file is read: references lead somewhere, views lie in their buffers, nodes are a forest.

use super::super::fault::{Fault, Faults, Kind};
use super::accessors;
use super::json::{Document, Primitive};
use super::json_materials::TextureInfo;
use super::{meshes, nodes};

/// All references of a file.
struct References<'a> {
    document: &'a Document,
    faults: &'a mut Faults,
}

/// Checks a whole file; at most fifty faults are reported.
pub(super) fn check(document: &Document) -> Result<(), Faults> {
    let mut faults = Faults::default();
    views(document, &mut faults);
    accessors::check_all(document, &mut faults);
    let mut references = References { document, faults: &mut faults };
    references.pictures();
    references.materials();
    references.meshes();
    references.others();
    nodes::check_forest(document, &mut faults);
    faults.none_or_err()
}

fn views(document: &Document, faults: &mut Faults) {
    for (index, view) in document.views.iter().enumerate() {
        let pointer = format!("/bufferViews/{index}");
        let Some(buffer) = document.buffers.get(view.buffer) else {
            let detail = format!("there is no buffer {}", view.buffer);
            faults.push(Fault::new(format!("{pointer}/buffer"), Kind::UnknownReference, detail));
            continue;
        };
        let end = view.byte_offset.checked_add(view.byte_length);
        if end.is_none_or(|end| end > buffer.byte_length) {
            let key = if view.byte_offset >= buffer.byte_length { "byteOffset" } else { "byteLength" };
            let detail = format!(
                "{} bytes from {} do not lie in buffer {}, which has {}",
                view.byte_length, view.byte_offset, view.buffer, buffer.byte_length
            );
            faults.push(Fault::new(format!("{pointer}/{key}"), Kind::OutOfBounds, detail));
        }
        if view.byte_length == 0 {
            faults.push(Fault::new(format!("{pointer}/byteLength"), Kind::OutOfRange, "it must be at least 1"));
        }
        if view.byte_stride.is_some_and(|stride| !(4..=252).contains(&stride)) {
            faults.push(Fault::new(format!("{pointer}/byteStride"), Kind::OutOfRange, "it must be from 4 to 252"));
        }
    }
}

impl References<'_> {
    fn one(&mut self, pointer: String, index: usize, count: usize, what: &str) {
        if index >= count {
            self.faults.push(Fault::new(pointer, Kind::UnknownReference, format!("there is no {what} {index}")));
        }
    }

    fn pictures(&mut self) {
        let document = self.document;
        for (i, texture) in document.textures.iter().enumerate() {
            let images = document.images.len();
            let pointer = format!("/textures/{i}");
            if let Some(source) = texture.source {
                self.one(format!("{pointer}/source"), source, images, "image");
            }
            for (name, extension) in
                [("EXT_texture_webp", &texture.extensions.webp), ("KHR_texture_basisu", &texture.extensions.basisu)]
            {
                if let Some(source) = extension.as_ref().and_then(|extension| extension.source) {
                    self.one(format!("{pointer}/extensions/{name}/source"), source, images, "image");
                }
            }
            if let Some(sampler) = texture.sampler {
                self.one(format!("{pointer}/sampler"), sampler, document.samplers.len(), "sampler");
            }
        }
        for (i, image) in document.images.iter().enumerate() {
            if let Some(view) = image.buffer_view {
                self.one(format!("/images/{i}/bufferView"), view, document.views.len(), "bufferView");
            }
        }
    }

    fn materials(&mut self) {
        let document = self.document;
        for (i, material) in document.materials.iter().enumerate() {
            let (pbr, more) = (&material.pbr_metallic_roughness, &material.extensions);
            let (specular, coat) = (more.specular.as_ref(), more.clearcoat.as_ref());
            let glossiness = more.glossiness.as_ref();
            let infos: [(&str, Option<&TextureInfo>); 13] = [
                ("pbrMetallicRoughness/baseColorTexture", pbr.base_color_texture.as_ref()),
                ("pbrMetallicRoughness/metallicRoughnessTexture", pbr.metallic_roughness_texture.as_ref()),
                ("normalTexture", material.normal_texture.as_ref()),
                ("occlusionTexture", material.occlusion_texture.as_ref()),
                ("emissiveTexture", material.emissive_texture.as_ref()),
                (
                    "extensions/KHR_materials_transmission/transmissionTexture",
                    more.transmission.as_ref().and_then(|transmission| transmission.transmission_texture.as_ref()),
                ),
                (
                    "extensions/KHR_materials_specular/specularTexture",
                    specular.and_then(|specular| specular.specular_texture.as_ref()),
                ),
                (
                    "extensions/KHR_materials_specular/specularColorTexture",
                    specular.and_then(|specular| specular.specular_color_texture.as_ref()),
                ),
                (
                    "extensions/KHR_materials_clearcoat/clearcoatTexture",
                    coat.and_then(|coat| coat.clearcoat_texture.as_ref()),
                ),
                (
                    "extensions/KHR_materials_clearcoat/clearcoatRoughnessTexture",
                    coat.and_then(|coat| coat.clearcoat_roughness_texture.as_ref()),
                ),
                (
                    "extensions/KHR_materials_clearcoat/clearcoatNormalTexture",
                    coat.and_then(|coat| coat.clearcoat_normal_texture.as_ref()),
                ),
                (
                    "extensions/KHR_materials_pbrSpecularGlossiness/diffuseTexture",
                    glossiness.and_then(|glossiness| glossiness.diffuse_texture.as_ref()),
                ),
                (
                    "extensions/KHR_materials_pbrSpecularGlossiness/specularGlossinessTexture",
                    glossiness.and_then(|glossiness| glossiness.specular_glossiness_texture.as_ref()),
                ),
            ];
            for (key, info) in infos {
                if let Some(info) = info {
                    let pointer = format!("/materials/{i}/{key}");
                    self.one(format!("{pointer}/index"), info.index, document.textures.len(), "texture");
                    if let Some(detail) = info.transform().and_then(|transform| transform.fault()) {
                        let pointer = format!("{pointer}/extensions/KHR_texture_transform");
                        self.faults.push(Fault::new(pointer, Kind::OutOfRange, detail));
                    }
                }
            }
        }
    }

    fn meshes(&mut self) {
        for (i, mesh) in self.document.meshes.iter().enumerate() {
            for (j, primitive) in mesh.primitives.iter().enumerate() {
                self.primitive(&format!("/meshes/{i}/primitives/{j}"), primitive);
            }
        }
    }

    fn primitive(&mut self, pointer: &str, primitive: &Primitive) {
        let document = self.document;
        let accessors = &document.accessors;
        let base = primitive.attributes.get("POSITION").and_then(|index| accessors.get(*index));
        let lists = std::iter::once((format!("{pointer}/attributes"), &primitive.attributes))
            .chain(primitive.targets.iter().enumerate().map(|(k, target)| (format!("{pointer}/targets/{k}"), target)));
        for (list, attributes) in lists {
            for (name, &index) in attributes {
                let pointer = format!("{list}/{}", name.replace('~', "~0").replace('/', "~1"));
                let Some(accessor) = accessors.get(index) else {
                    self.one(pointer, index, accessors.len(), "accessor");
                    continue;
                };
                if base.is_some_and(|base| base.count != accessor.count) {
                    let detail = format!(
                        "it has {} elements, and the positions of the primitive are {}",
                        accessor.count,
                        base.map_or(0, |base| base.count)
                    );
                    self.faults.push(Fault::new(pointer, Kind::OutOfRange, detail));
                }
            }
        }
        if let Some(indices) = primitive.indices {
            self.one(format!("{pointer}/indices"), indices, accessors.len(), "accessor");
        }
        if let Some(material) = primitive.material {
            self.one(format!("{pointer}/material"), material, document.materials.len(), "material");
        }
        if let Some(draco) = &primitive.extensions.draco {
            let pointer = format!("{pointer}/extensions/KHR_draco_mesh_compression/bufferView");
            self.one(pointer, draco.buffer_view, document.views.len(), "bufferView");
        }
        if primitive.mode > 6 {
            let detail = format!("the mode {} is none of 0 to 6", primitive.mode);
            self.faults.push(Fault::new(format!("{pointer}/mode"), Kind::OutOfRange, detail));
        }
        let mappings = primitive.extensions.variants.iter().flat_map(|variants| &variants.mappings).enumerate();
        for (k, mapping) in mappings {
            let pointer = format!("{pointer}/extensions/KHR_materials_variants/mappings/{k}/material");
            self.one(pointer, mapping.material, document.materials.len(), "material");
        }
    }

    fn others(&mut self) {
        let document = self.document;
        let nodes = document.nodes.len();
        for (i, skin) in document.skins.iter().enumerate() {
            for (k, &joint) in skin.joints.iter().enumerate() {
                self.one(format!("/skins/{i}/joints/{k}"), joint, nodes, "node");
            }
            if let Some(skeleton) = skin.skeleton {
                self.one(format!("/skins/{i}/skeleton"), skeleton, nodes, "node");
            }
            if let Some(matrices) = skin.inverse_bind_matrices {
                let pointer = format!("/skins/{i}/inverseBindMatrices");
                self.one(pointer.clone(), matrices, document.accessors.len(), "accessor");
                let fewer =
                    document.accessors.get(matrices).filter(|accessor| accessor.count < skin.joints.len() as u64);
                if let Some(accessor) = fewer {
                    let detail = format!("{} matrices are too few for {} joints", accessor.count, skin.joints.len());
                    self.faults.push(Fault::new(pointer, Kind::OutOfRange, detail));
                }
            }
        }
        for (i, animation) in document.animations.iter().enumerate() {
            for (k, channel) in animation.channels.iter().enumerate() {
                let pointer = format!("/animations/{i}/channels/{k}");
                self.one(format!("{pointer}/sampler"), channel.sampler, animation.samplers.len(), "sampler");
                if let Some(node) = channel.target.node {
                    self.one(format!("{pointer}/target/node"), node, nodes, "node");
                }
            }
            for (k, sampler) in animation.samplers.iter().enumerate() {
                let pointer = format!("/animations/{i}/samplers/{k}");
                let accessors = document.accessors.len();
                self.one(format!("{pointer}/input"), sampler.input, accessors, "accessor");
                self.one(format!("{pointer}/output"), sampler.output, accessors, "accessor");
            }
        }
        if let Some(scene) = document.scene {
            self.one("/scene".into(), scene, document.scenes.len(), "scene");
        }
        for (i, node) in document.nodes.iter().enumerate() {
            for (key, index, count) in [
                ("mesh", node.mesh, document.meshes.len()),
                ("skin", node.skin, document.skins.len()),
                ("camera", node.camera, document.cameras.len()),
            ] {
                if let Some(index) = index {
                    self.one(format!("/nodes/{i}/{key}"), index, count, key);
                }
            }
            if let Some(light) = &node.extensions.light {
                let pointer = format!("/nodes/{i}/extensions/KHR_lights_punctual/light");
                self.one(pointer, light.light, document.lights.len(), "light");
            }
            if let Some(instancing) = &node.extensions.instancing {
                for (name, &index) in &instancing.attributes {
                    let pointer = format!("/nodes/{i}/extensions/EXT_mesh_gpu_instancing/attributes/{name}");
                    self.one(pointer, index, document.accessors.len(), "accessor");
                }
            }
        }
    }
}

/// What would be wrong with the parts of a file of which nothing is seen: all numbers, pictures and skins.
pub(super) fn check_unseen(document: &Document, buffers: &super::buffers::Buffers<'_>, faults: &mut Faults) {
    const ALL: [&str; 7] = ["SCALAR", "VEC2", "VEC3", "VEC4", "MAT2", "MAT3", "MAT4"];
    for index in 0..document.accessors.len() {
        faults.note(buffers.elements::<16>(document, index, &ALL).map(drop));
    }
    for (i, mesh) in document.meshes.iter().enumerate() {
        for (j, primitive) in mesh.primitives.iter().enumerate() {
            let pointer = format!("/meshes/{i}/primitives/{j}");
            let Some(&positions) = primitive.attributes.get("POSITION") else { continue };
            let count = document.accessors[positions].count as usize;
            faults.note(meshes::triangles(document, buffers, primitive, &pointer, count).map(drop));
        }
    }
    super::skins::check(document, buffers, faults);
}
