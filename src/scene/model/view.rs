//! From where a model is seen: a name, or two angles of an orbit.

use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use serde::{Deserialize, Deserializer, Serialize, Serializer, de::Error};
use std::borrow::Cow;
use std::fmt;
use std::str::FromStr;

/// A point of the orbit around a model. It faces +z, with +y up.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct View {
    /// Degrees around the vertical axis, from the front towards +x.
    pub theta: f64,
    /// Degrees from straight above, 0 to 180.
    pub phi: f64,
}

/// The corner of a box in the middle of which lie three sides: the angle whose cosine is 1/sqrt(3).
const ISOMETRIC: f64 = 54.735_610_317_245_35;

const NAMES: [(&str, View); 8] = [
    ("three_quarter", View { theta: 30.0, phi: 70.0 }),
    ("front", View { theta: 0.0, phi: 90.0 }),
    ("back", View { theta: 180.0, phi: 90.0 }),
    ("left", View { theta: 90.0, phi: 90.0 }),
    ("right", View { theta: -90.0, phi: 90.0 }),
    ("top", View { theta: 0.0, phi: 0.0 }),
    ("bottom", View { theta: 0.0, phi: 180.0 }),
    ("iso", View { theta: 45.0, phi: ISOMETRIC }),
];

impl View {
    /// What may be written.
    pub const WRITTEN: &'static str = "three_quarter, front, back, left, right, top, bottom, iso, or two angles in degrees as 30,70: the first from -360 to 360, the second from 0 to 180";
    /// The same as a pattern.
    pub const PATTERN: &'static str = "^(three_quarter|front|back|left|right|top|bottom|iso|-?[0-9.]+,[0-9.]+)$";
}

impl Default for View {
    fn default() -> Self {
        NAMES[0].1
    }
}

impl FromStr for View {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        if let Some((_, view)) = NAMES.iter().find(|(name, _)| *name == text) {
            return Ok(*view);
        }
        let angles = text.split_once(',').and_then(|(theta, phi)| {
            let (theta, phi): (f64, f64) = (theta.trim().parse().ok()?, phi.trim().parse().ok()?);
            (theta.abs() <= 360.0 && (0.0..=180.0).contains(&phi)).then_some(Self { theta, phi })
        });
        angles.ok_or_else(|| format!("expected {}", Self::WRITTEN))
    }
}

impl fmt::Display for View {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match NAMES.iter().find(|(_, view)| view == self) {
            Some((name, _)) => f.write_str(name),
            None => write!(f, "{},{}", self.theta, self.phi),
        }
    }
}

impl Serialize for View {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_str(self)
    }
}

impl<'de> Deserialize<'de> for View {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        String::deserialize(deserializer)?.parse().map_err(D::Error::custom)
    }
}

impl JsonSchema for View {
    fn schema_name() -> Cow<'static, str> {
        "View".into()
    }
    fn json_schema(_: &mut SchemaGenerator) -> Schema {
        json_schema!({ "type": "string", "pattern": Self::PATTERN })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn views_have_names_or_angles() {
        assert_eq!("top".parse(), Ok(View { theta: 0.0, phi: 0.0 }));
        assert_eq!("-30,70.5".parse(), Ok(View { theta: -30.0, phi: 70.5 }));
        assert_eq!(View::default().to_string(), "three_quarter");
        assert_eq!("12.5,90".parse::<View>().unwrap().to_string(), "12.5,90");
        for wrong in ["", "up", "30", "30,200", "nan,70", "400,70"] {
            assert!(wrong.parse::<View>().is_err(), "{wrong}");
        }
    }
}
