//! Another view of a model: a variation of the first, with which it has bodies and materials in common.

use super::compile::Original;
use super::load::{Accept, Loaded, NotLoaded, Steps};
use super::model::Views;
use super::nff::NffOptions;
use super::{Files, Overrides};
use std::sync::Arc;
use std::time::Instant;

impl Views {
    /// Another view of a model, if `accept` wants it, in the hierarchies and with the pictures of `original`, which is one. None if
    /// only one of the two has a floor: then the model has to be read again.
    pub fn again<E>(
        &self,
        original: Original<'_>,
        overrides: &Overrides,
        files: &dyn Files,
        accept: Accept<'_, E>,
    ) -> Result<Option<Loaded>, NotLoaded<E>> {
        let (start, own) = (Instant::now(), original.description);
        let bodies = &own.objects[..self.bodies.min(own.objects.len())];
        let seen = self.seen(bodies, &own.definitions, &own.materials, overrides)?;
        if seen.has_floor != self.has_floor(own) {
            return Ok(None);
        }
        let (definitions, objects) = (Arc::clone(&own.definitions), Arc::clone(&own.objects));
        let mut description = self.around(seen, definitions, objects, own.materials.clone());
        overrides.apply(&mut description);
        let steps = Steps::read(start);
        let (mut pictures, warnings) = steps.checked(&description, files, accept, Some(original))?;
        pictures.from_files |= original.scene.from_files;
        let scene = steps.build(&description, NffOptions::default(), pictures, warnings, Some(original))?;
        Ok(Some(steps.loaded(description, scene, NffOptions::default(), Vec::new())))
    }
}
