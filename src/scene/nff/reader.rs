//! From tokens to entities. As in the SPD's own reader, readnff.c, line ends have no meaning inside an entity; the reader
//! uses them only to go on after a mistake.

use super::entity::{Cone, Entity, Fill, Kind, Light, Patch, Sphere, View};
use super::tokens::{Place, Token, Tokens};
use crate::control;
use crate::scene::description::Vec3;
use crate::scene::limits;
use crate::scene::problem::{Code, Problem};
use std::fmt::Display;

/// Reads one entity after the other.
#[derive(Debug)]
pub(super) struct Reader<'a> {
    tokens: Tokens<'a>,
    /// The entity being read, or the one before.
    current: Option<(Kind, Place)>,
}

impl<'a> Reader<'a> {
    pub(super) fn new(text: &'a [u8]) -> Self {
        Self { tokens: Tokens::new(text), current: None }
    }

    /// The end of what was read.
    pub(super) fn place(&self) -> Place {
        self.tokens.place()
    }

    /// Goes on after a problem, with the next line that starts with an entity. Returns the one that had the problem.
    pub(super) fn recover(&mut self) -> Option<(Kind, Place)> {
        let starts_entity =
            |token: Token<'_>| token.starts_line && (Kind::of_keyword(token.text).is_some() || is_assimp(token));
        while self.tokens.peek().is_some_and(|token| !starts_entity(token)) {
            self.tokens.next();
        }
        self.current.take()
    }

    /// The next entity and where it starts; none at the end.
    pub(super) fn entity(&mut self) -> Result<Option<(Place, Entity)>, Problem> {
        let Some(token) = self.tokens.next().filter(|_| !control::step(1)) else { return Ok(None) };
        let kind = Kind::of_keyword(token.text).ok_or_else(|| self.not_an_entity(token))?;
        self.current = Some((kind, token.place));
        let entity = match kind {
            Kind::View => Entity::View(self.view()?),
            Kind::Background => Entity::Background(self.color("the color")?),
            Kind::Light => Entity::Light(self.light()?),
            Kind::Fill => Entity::Fill(self.fill()?),
            Kind::Cone => Entity::Cone(self.cone()?),
            Kind::Sphere => {
                Entity::Sphere(Sphere { center: self.point("the centre")?, radius: self.number("the radius")? })
            }
            Kind::Polygon => Entity::Polygon(self.polygon()?),
            Kind::Patch => Entity::Patch(self.patch()?),
        };
        Ok(Some((token.place, entity)))
    }

    fn view(&mut self) -> Result<View, Problem> {
        self.word("from")?;
        let from = self.point("from")?;
        self.word("at")?;
        let at = self.point("at")?;
        self.word("up")?;
        let up = self.point("up")?;
        self.word("angle")?;
        let angle = self.number_in("the angle", "above 0 and below 180 degrees", |x| x > 0.0 && x < 180.0)?;
        if self.word("hither").is_ok() {
            self.number("hither")?;
        }
        let resolution = if self.word("resolution").is_ok() { [self.side()?, self.side()?] } else { [512, 512] };
        Ok(View { from, at, up, angle, resolution })
    }

    /// One side of the resolution.
    fn side(&mut self) -> Result<u32, Problem> {
        let place = self.place();
        let side =
            self.number_in("the resolution", "a whole number of at least 1", |x| x >= 1.0 && x.fract() == 0.0)?;
        at_most(limits::IMAGE_SIDE, side, place)?;
        Ok(side as u32)
    }

    fn light(&mut self) -> Result<Light, Problem> {
        let position = self.point("the position")?;
        // a color has no keyword; but whatever else may follow starts with one
        let has_color = self.tokens.peek().is_some_and(|token| token.is_number());
        let color = if has_color { Some(self.color("the color")?) } else { None };
        Ok(Light { position, color })
    }

    fn fill(&mut self) -> Result<Fill, Problem> {
        let color = self.color("the color")?;
        let kd = self.weight("Kd")?;
        let ks = self.weight("Ks")?;
        let shine = self.number_in("Shine", "from 0 to 1e6", |x| (0.0..=1e6).contains(&x))?;
        let swapped = "from 0 to 1; are Shine and T swapped?";
        let transmittance = self.number_in("the transmittance T", swapped, |x| (0.0..=1.0).contains(&x))?;
        // opaque fills have an index of any value, mostly 0 or 1, which is not used
        let refracts = |x: f64| transmittance == 0.0 || (0.01..=100.0).contains(&x);
        let ior = self.number_in("the index of refraction of what transmits", "from 0.01 to 100", refracts)?;
        Ok(Fill { color, kd, ks, shine, transmittance, ior })
    }

    fn cone(&mut self) -> Result<Cone, Problem> {
        let base = self.point("the base")?;
        let base_radius = self.number("the base's radius")?;
        let apex = self.point("the apex")?;
        let apex_radius = self.number("the apex's radius")?;
        Ok(Cone { base, base_radius, apex, apex_radius })
    }

    fn polygon(&mut self) -> Result<Vec<Vec3>, Problem> {
        let count = self.count()?;
        (1..=count).map(|i| self.point(format_args!("vertex {i} of {count}"))).collect()
    }

    fn patch(&mut self) -> Result<Patch, Problem> {
        let count = self.count()?;
        let mut patch = Patch { vertices: Vec::new(), normals: Vec::new() };
        for i in 1..=count {
            patch.vertices.push(self.point(format_args!("vertex {i} of {count}"))?);
            let place = self.place();
            let normal = self.point(format_args!("the normal of vertex {i} of {count}"))?;
            if normal == [0.0; 3] {
                return Err(place.problem(Code::Degenerate, format!("the normal of vertex {i} is 0 0 0")));
            }
            patch.normals.push(normal);
        }
        Ok(patch)
    }

    /// How many vertices follow.
    fn count(&mut self) -> Result<usize, Problem> {
        let place = self.place();
        let rule = "a whole number of at least 3";
        let count = self.number_in("the number of vertices", rule, |x| x >= 3.0 && x.fract() == 0.0)?;
        at_most(limits::POLYGON_VERTICES, count, place)?;
        Ok(count as usize)
    }

    fn point(&mut self, what: impl Display + Copy) -> Result<Vec3, Problem> {
        Ok([self.number(what)?, self.number(what)?, self.number(what)?])
    }

    fn color(&mut self, what: impl Display + Copy) -> Result<Vec3, Problem> {
        Ok([self.weight(what)?, self.weight(what)?, self.weight(what)?])
    }

    fn weight(&mut self, what: impl Display + Copy) -> Result<f64, Problem> {
        self.number_in(what, "at least 0", |x| x >= 0.0)
    }

    fn number_in(
        &mut self,
        what: impl Display + Copy,
        rule: &str,
        allows: impl Fn(f64) -> bool,
    ) -> Result<f64, Problem> {
        let place = self.place();
        let number = self.number(what)?;
        if allows(number) {
            return Ok(number);
        }
        Err(place.problem(Code::OutOfRange, format!("{what} is {number}, but must be {rule}")))
    }

    fn number(&mut self, what: impl Display + Copy) -> Result<f64, Problem> {
        let expected = || self.expected(format_args!("a number for {what}"));
        let token = self.tokens.peek().ok_or_else(expected)?;
        let number = token.number().ok_or_else(expected)?;
        if number.abs() > limits::MAGNITUDE {
            let detail = format!("{} is out of range; numbers go up to {:e}", token.quoted(), limits::MAGNITUDE);
            return Err(token.place.problem(Code::OutOfRange, detail));
        }
        self.tokens.next();
        Ok(number)
    }

    fn word(&mut self, word: &str) -> Result<(), Problem> {
        if self.tokens.peek().is_some_and(|token| token.text == word.as_bytes()) {
            self.tokens.next();
            return Ok(());
        }
        Err(self.expected(format_args!("the word \"{word}\"")))
    }

    /// The problem that the next token is not what the current entity needs.
    fn expected(&self, what: impl Display + Copy) -> Problem {
        let found = self.tokens.peek().map_or_else(|| "the end of the file".to_owned(), |token| token.quoted());
        let (form, start) = self.current.map_or(("", 0), |(kind, place)| (kind.form(), place.line));
        let detail = format!("expected {what}, found {found}; line {start} starts {form}");
        self.place().problem(Code::InvalidNff, detail)
    }

    /// The problem that the next token does not start an entity. Names the dialect it is from, if known.
    fn not_an_entity(&self, token: Token<'_>) -> Problem {
        let found = token.quoted();
        let dialect = |what: &str| {
            let detail = format!("{what}. This is assimp's dialect of NFF, not the SPD's, and is not supported");
            token.place.problem(Code::Unsupported, detail)
        };
        if is_assimp(token) {
            return dialect(&format!("{found} is no entity of NFF"));
        }
        let detail = match self.current {
            Some((Kind::Fill, _)) if !token.is_number() && !token.starts_line => {
                return dialect(&format!("{found} after a fill can only be a texture, which NFF does not have"));
            }
            Some((Kind::Sphere, _)) if token.is_number() && !token.starts_line => {
                return dialect(&format!("{found} is one number too many for {}", Kind::Sphere.form()));
            }
            Some((Kind::Polygon | Kind::Patch, start)) if token.is_number() => {
                format!("{found} is one number too many: line {} announces fewer vertices than follow", start.line)
            }
            Some((kind, start)) if token.is_number() => {
                format!("{found} is one number too many: line {} starts {}", start.line, kind.form())
            }
            _ => format!("{found} starts no entity; entities are {}", Kind::KEYWORDS),
        };
        token.place.problem(Code::InvalidNff, detail)
    }
}

/// Whether it is one of the keywords that assimp adds to NFF.
fn is_assimp(token: Token<'_>) -> bool {
    matches!(token.text, b"tess" | b"tet" | b"oct" | b"hex" | b"dod")
}

fn at_most(limit: limits::Limit, value: f64, place: Place) -> Result<(), Problem> {
    if value <= limit.max as f64 {
        return Ok(());
    }
    Err(place.problem(Code::Limit, format!("{value} is more than the limit {} of {}", limit.name, limit.max)))
}
