//! Projections: from a point of the picture to the primary ray.

mod angular;
mod edges;
mod flat;
mod lens;
mod window;

pub use angular::Angular;
pub use edges::PictureEdges;
pub use flat::Flat;
pub use lens::Lens;
pub use window::Window;

use crate::lanes::{Lanes, Real, V3};
use glam::DVec3;

/// A camera in the kernel's format.
#[derive(Debug, Clone, Copy)]
pub enum Camera<R> {
    /// Pinhole and orthographic: rays are affine in the pixel.
    Flat(Flat<R>),
    /// Pinhole with a lens.
    Lens(Flat<R>, Lens<R>),
    /// Fisheye, dome, panorama, cylinder: directions are angles.
    Angular(Angular),
}

/// A primary ray in each lane.
#[derive(Debug, Clone, Copy)]
pub struct Primary<L: Lanes> {
    /// Start.
    pub origin: V3<L>,
    /// Unit direction.
    pub dir: V3<L>,
    /// Lanes whose point lies inside the picture's circle; the others show the background.
    pub seen: L::Mask,
}

/// How the rays of one pixel widen: by `spread` with each unit of distance from a width at their origin.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Cone {
    /// Width where the ray starts.
    pub width: f64,
    /// Width gained in a unit of distance.
    pub spread: f64,
}

/// Where a camera stands and what it faces.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct View {
    /// Eye point.
    pub eye: [f64; 3],
    /// Point in the middle of the picture.
    pub look_at: [f64; 3],
    /// Direction that points up in the picture; need not be perpendicular.
    pub up: [f64; 3],
}

/// Orthonormal axes of a camera: right, up and forward.
#[derive(Debug, Clone, Copy)]
pub struct Basis {
    /// Eye point.
    pub eye: DVec3,
    /// To the right in the picture.
    pub right: DVec3,
    /// Up in the picture.
    pub up: DVec3,
    /// Into the picture.
    pub forward: DVec3,
}

impl Basis {
    /// The axes of a view; `None` if eye and target coincide or `up` is parallel to the view.
    pub fn new(view: &View) -> Option<Self> {
        let eye = DVec3::from_array(view.eye);
        let forward = (DVec3::from_array(view.look_at) - eye).try_normalize()?;
        let up = DVec3::from_array(view.up).try_normalize()?;
        let across = forward.cross(up);
        // Below 1e-9 the picture's roll would be rounding noise.
        if across.length() < 1e-9 {
            return None;
        }
        let right = across.normalize();
        Some(Self { eye, right, up: right.cross(forward), forward })
    }
}

impl<R: Real> Camera<R> {
    /// The camera whose picture is what a window shows of this one's. Windows of powers of two give the same rays as
    /// larger or smaller pictures of the same camera do, to the last bit.
    #[must_use]
    pub fn through(&self, window: &Window) -> Self {
        match *self {
            Self::Flat(flat) => Self::Flat(flat.through(window)),
            Self::Lens(flat, lens) => Self::Lens(flat.through(window), lens),
            Self::Angular(angular) => Self::Angular(angular.through(window)),
        }
    }

    /// Whether straight lines stay straight and near things look larger, as in a photograph.
    pub fn is_pinhole(&self) -> bool {
        matches!(self, Self::Flat(Flat { parallel: false, .. }) | Self::Lens(..))
    }

    /// The lens, if there is one.
    #[inline(always)]
    pub fn lens(&self) -> Option<&Lens<R>> {
        if let Self::Lens(_, lens) = self { Some(lens) } else { None }
    }

    /// The cone of a pixel in the middle of the picture.
    pub fn cone(&self) -> Cone {
        match self {
            Self::Flat(flat) | Self::Lens(flat, _) => flat.cone(),
            Self::Angular(angular) => Cone { width: 0.0, spread: angular.spread() },
        }
    }

    /// The point of the picture that shows a point of the scene: the inverse of [`primary`](Self::primary). `None` if no
    /// point of the picture's plane does, or circle, or whatever the projection has. It may lie outside of the picture. With a
    /// lens it is where the point is seen through the lens's middle.
    pub fn project(&self, point: DVec3) -> Option<[f64; 2]> {
        match self {
            Self::Flat(flat) | Self::Lens(flat, _) => flat.project(point),
            Self::Angular(angular) => angular.project(point),
        }
    }

    /// The part of a segment that the camera can see: what lies in front of the eye, for flat pictures.
    pub fn clip(&self, segment: [DVec3; 2]) -> Option<[DVec3; 2]> {
        match self {
            Self::Flat(flat) | Self::Lens(flat, _) => flat.clip(segment),
            Self::Angular(_) => Some(segment),
        }
    }

    /// The eye of an angular projection, whose pictures of straight lines are curves.
    pub fn bends_around(&self) -> Option<DVec3> {
        if let Self::Angular(angular) = self { Some(angular.eye()) } else { None }
    }

    /// Primary rays through the points (x, y) of the picture, in pixels from its upper left corner. With a lens, they pass
    /// through its middle.
    #[inline(always)]
    pub fn primary<L: Lanes<Real = R>>(&self, s: L::Simd, x: L, y: L) -> Primary<L> {
        match self {
            Self::Flat(flat) | Self::Lens(flat, _) => flat.primary(s, x, y),
            Self::Angular(angular) => angular.primary(s, &x, &y),
        }
    }
}
