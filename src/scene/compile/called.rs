//! Which effects can show in a picture: what has no strength, no size or no body does not count.

use crate::accel::{Geometry, Item};
use crate::lanes::Real;
use crate::scene::called::Called;
use crate::scene::description::{Description, Shadows};
use crate::shading::light::Light;
use crate::shading::material::{Fresnel, Material};

/// The effects that the bodies of a scene and its lights call for; what the camera, the air and the surroundings call for
/// is for the caller to add. Definitions that nothing places have not been built.
pub(super) fn called<R: Real>(
    description: &Description,
    geometries: &[Geometry<R>],
    materials: &[Material<R>],
    lights: &[Light<R>],
) -> Called {
    let bodies = || geometries.iter().flat_map(|geometry| &geometry.items).filter(|item| !item.is_placed());
    let of = |item: &Item<R>| &materials[item.material as usize];
    let any = |calls: &dyn Fn(&Material<R>) -> bool| bodies().any(|item| calls(of(item)));
    let shows = |color: [R; 3]| color.iter().any(|c| *c > R::from_f64(0.0));
    let mirrors = |m: &Material<R>| shows(m.reflection) || m.fresnel == Fresnel::Conductor;
    // Light is inside of what it gets into; cavities are empty.
    let absorption = bodies().any(|item| {
        let filled = item.closed && !item.hollow && item.lets_light_through();
        filled && shows(of(item).absorption)
    });
    let follows = description.render.max_depth != Some(1);
    let zero = R::from_f64(0.0);
    Called {
        absorption,
        area_lights: lights.iter().any(|light| light.area.is_some() && shows(light.color)),
        bleeding: follows && description.render.color_bleeding,
        colored_shadows: absorption && description.render.shadows == Shadows::Transmissive && !lights.is_empty(),
        dispersion: follows && any(&|m| m.dispersion > zero && shows(m.transmission)),
        emission: any(&|m| shows(m.emission)),
        fresnel: follows
            && any(&|m| match m.fresnel {
                Fresnel::None => false,
                Fresnel::Dielectric => shows(m.reflection) || shows(m.transmission),
                Fresnel::Conductor => true,
            }),
        gloss: follows && any(&|m| m.alpha > zero && (mirrors(m) || shows(m.transmission))),
        paint: any(&|m| m.textures.is_some()),
        ..Called::default()
    }
}
