//! ETC1S with BasisLZ (KTX 2.0, appendices B and C): blocks of 4 x 4 pixels name one of the colors and one of the patterns
//! that all blocks share, and most names are predicted from those of blocks before.

use super::bits::Bits;
use super::huffman::Huffman;
use super::{Failure, Pixels, word};
use crate::control;

/// By how much the four selectors of a block change its color (ETC1, Khronos Data Format Specification 1.3, section 21.1).
const MODIFIERS: [[i32; 4]; 8] = [
    [-8, -2, 2, 8],
    [-17, -5, 5, 17],
    [-29, -9, 9, 29],
    [-42, -13, 13, 42],
    [-60, -18, 18, 60],
    [-80, -24, 24, 80],
    [-106, -33, 33, 106],
    [-183, -47, 47, 183],
];
/// The symbol that repeats the predictions of the last four blocks.
const REPEAT: u32 = 256;
/// The shortest run of anything.
const RUN: u32 = 3;
/// The symbol of a run of selectors whose length is a number of its own.
const LONG_RUN: u32 = 63;

/// What all slices share.
#[derive(Debug)]
pub(super) struct Codebooks {
    /// The four colors of each endpoint.
    colors: Vec<[[u8; 3]; 4]>,
    /// Rows of four selectors of two bits, the left one lowest.
    selectors: Vec<[u8; 4]>,
    tables: Tables,
    /// Where the slices of the largest level are: offsets and lengths of color and of opacity.
    slices: [[u32; 2]; 2],
}

/// Codes of the slices.
#[derive(Debug)]
struct Tables {
    predictions: Huffman,
    endpoints: Huffman,
    selectors: Huffman,
    runs: Huffman,
    history: usize,
}

impl Codebooks {
    /// Reads the global data of BasisLZ for a file with so many pictures.
    pub(super) fn read(shared: &[u8], pictures: usize) -> Result<Self, Failure> {
        let counts = word(shared, 0)?;
        let (endpoints, selectors) = (counts & 0xffff, counts >> 16);
        if word(shared, 20)? & 2 != 0 {
            return Err("is a frame of a video".into());
        }
        let slices = [[word(shared, 24)?, word(shared, 28)?], [word(shared, 32)?, word(shared, 36)?]];
        let mut rest = shared.get(20 + 20 * pictures..).ok_or("ends too early")?;
        let mut next = |at: usize| -> Result<Bits<'_>, Failure> {
            let (part, after) = rest.split_at_checked(word(shared, at)? as usize).ok_or("ends too early")?;
            rest = after;
            Ok(Bits::new(part))
        };
        let colors = colors(&mut next(4)?, endpoints)?;
        let selectors = patterns(&mut next(8)?, selectors)?;
        let mut bits = next(12)?;
        let mut table = || Huffman::read(&mut bits);
        let (predictions, endpoints, of_selectors, runs) = (table()?, table()?, table()?, table()?);
        let history = bits.take(13)? as usize;
        let tables = Tables { predictions, endpoints, selectors: of_selectors, runs, history };
        Ok(Self { colors, selectors, tables, slices })
    }

    /// Sets red, green and blue, and no transparency.
    pub(super) fn color(&self, level: &[u8], pixels: &mut Pixels) -> Result<(), Failure> {
        self.slice(level, 0, pixels, |pixel, [red, green, blue]| *pixel = [red, green, blue, 0xff])
    }

    /// Sets alpha.
    pub(super) fn opacity(&self, level: &[u8], pixels: &mut Pixels) -> Result<(), Failure> {
        self.slice(level, 1, pixels, |pixel, color| pixel[3] = color[1])
    }

    fn slice(
        &self,
        level: &[u8],
        which: usize,
        pixels: &mut Pixels,
        set: fn(&mut [u8; 4], [u8; 3]),
    ) -> Result<(), Failure> {
        let [start, length] = self.slices[which].map(|number| number as usize);
        let slice = level.get(start..).and_then(|rest| rest.get(..length));
        let [columns, rows] = pixels.blocks();
        let mut names = Names::new(self, slice.ok_or("ends too early")?, columns);
        for y in 0..rows {
            if control::step(columns as u32 / 16 + 1) {
                return Err("was not unpacked: loading was cancelled".into());
            }
            for x in 0..columns {
                let (endpoint, selector) = names.next(x, y)?;
                let found = self.colors.get(endpoint as usize).zip(self.selectors.get(selector as usize));
                let (colors, selectors) = found.ok_or("has a block without a color")?;
                pixels.change([x, y], |i, pixel| {
                    set(pixel, colors[usize::from(selectors[i / 4] >> (i % 4 * 2) & 3)]);
                });
            }
        }
        Ok(())
    }
}

/// Reads the colors.
fn colors(bits: &mut Bits<'_>, count: u32) -> Result<Vec<[[u8; 3]; 4]>, Failure> {
    let mut table = || Huffman::read(bits);
    let (of_colors, of_intensities) = ([table()?, table()?, table()?], table()?);
    let is_grey = bits.take(1)? == 1;
    let (mut intensity, mut color) = (0, [16_u32; 3]);
    let mut colors = Vec::new();
    for _ in 0..count {
        intensity = (intensity + of_intensities.next(bits)?) & 7;
        for channel in color.iter_mut().take(if is_grey { 1 } else { 3 }) {
            let table = match *channel {
                0..10 => &of_colors[0],
                10..22 => &of_colors[1],
                _ => &of_colors[2],
            };
            *channel = (*channel + table.next(bits)?) & 31;
        }
        if is_grey {
            color = [color[0]; 3];
        }
        let base = color.map(|channel| (channel << 3 | channel >> 2) as i32);
        let by = |modifier: i32| base.map(|channel| (channel + modifier).clamp(0, 255) as u8);
        colors.push(MODIFIERS[intensity as usize].map(by));
    }
    Ok(colors)
}

/// Reads the patterns of selectors.
fn patterns(bits: &mut Bits<'_>, count: u32) -> Result<Vec<[u8; 4]>, Failure> {
    if bits.take(2)? != 0 {
        return Err("has selectors of a reserved kind".into());
    }
    let is_raw = bits.take(1)? == 1;
    let table = if is_raw { None } else { Some(Huffman::read(bits)?) };
    let mut patterns: Vec<[u8; 4]> = Vec::new();
    for _ in 0..count {
        let mut pattern = [0; 4];
        for (row, before) in pattern.iter_mut().zip(patterns.last().copied().unwrap_or_default()) {
            *row = match &table {
                Some(table) if !patterns.is_empty() => table.next(bits)? as u8 ^ before,
                _ => bits.take(8)? as u8,
            };
        }
        patterns.push(pattern);
    }
    Ok(patterns)
}

/// The names of endpoints and selectors, block by block.
struct Names<'a> {
    tables: &'a Tables,
    bits: Bits<'a>,
    endpoints: u32,
    selectors: u32,
    /// Endpoints of the row above, which those of this row replace, and of the block to the upper left.
    above: Vec<u32>,
    corner: u32,
    endpoint: u32,
    /// Predictions for the lower two of four blocks.
    lower: Vec<u32>,
    predictions: u32,
    last: u32,
    repeats: u32,
    history: History,
    run: u32,
}

impl<'a> Names<'a> {
    fn new(codebooks: &'a Codebooks, slice: &'a [u8], columns: usize) -> Self {
        Self {
            tables: &codebooks.tables,
            bits: Bits::new(slice),
            endpoints: codebooks.colors.len() as u32,
            selectors: codebooks.selectors.len() as u32,
            above: vec![0; columns],
            corner: 0,
            endpoint: 0,
            lower: vec![0; columns.div_ceil(2)],
            predictions: 0,
            last: 0,
            repeats: 0,
            history: History::new(codebooks.tables.history),
            run: 0,
        }
    }

    fn next(&mut self, x: usize, y: usize) -> Result<(u32, u32), Failure> {
        if x.is_multiple_of(2) {
            self.predictions = if y.is_multiple_of(2) { self.four_predictions()? } else { self.lower[x / 2] };
            if y.is_multiple_of(2) {
                self.lower[x / 2] = self.predictions >> 4;
            }
        }
        let prediction = self.predictions & 3;
        self.predictions >>= 2;
        let (above, corner) = (self.above[x], self.corner);
        self.endpoint = match prediction {
            0 if x > 0 => self.endpoint,
            1 if y > 0 => above,
            2 if x > 0 && y > 0 => corner,
            3 => {
                let sum = self.endpoint + self.tables.endpoints.next(&mut self.bits)?;
                if sum >= self.endpoints { sum - self.endpoints } else { sum }
            }
            _ => return Err("has a block like one outside of the picture".into()),
        };
        (self.corner, self.above[x]) = (above, self.endpoint);
        Ok((self.endpoint, self.selector()?))
    }

    /// Two bits for each of 2 x 2 blocks.
    fn four_predictions(&mut self) -> Result<u32, Failure> {
        if self.repeats > 0 {
            self.repeats -= 1;
            return Ok(self.last);
        }
        match self.tables.predictions.next(&mut self.bits)? {
            REPEAT => self.repeats = self.bits.number(4)?.saturating_add(RUN - 1),
            predictions => self.last = predictions & 255,
        }
        Ok(self.last)
    }

    fn selector(&mut self) -> Result<u32, Failure> {
        let symbol = if self.run > 0 {
            self.run -= 1;
            self.selectors
        } else {
            self.tables.selectors.next(&mut self.bits)?
        };
        let Some(place) = symbol.checked_sub(self.selectors) else {
            self.history.add(symbol);
            return Ok(symbol);
        };
        let is_run = place as usize == self.tables.history;
        if is_run {
            let length = match self.tables.runs.next(&mut self.bits)? {
                LONG_RUN => self.bits.number(7)?,
                length => length,
            };
            self.run = length.saturating_add(RUN - 1);
        }
        let place = if is_run { 0 } else { place as usize };
        self.history.find(place).ok_or_else(|| "names a selector that was not there".into())
    }
}

/// Selectors of late; what is used again moves half the way to the front.
struct History {
    selectors: Vec<u32>,
    next: usize,
}

impl History {
    fn new(size: usize) -> Self {
        Self { selectors: vec![0; size], next: size / 2 }
    }

    fn add(&mut self, selector: u32) {
        if let Some(place) = self.selectors.get_mut(self.next) {
            *place = selector;
            self.next += 1;
            if self.next == self.selectors.len() {
                self.next = self.selectors.len() / 2;
            }
        }
    }

    fn find(&mut self, place: usize) -> Option<u32> {
        let selector = self.selectors.get(place).copied();
        if selector.is_some() {
            self.selectors.swap(place, place / 2);
        }
        selector
    }
}
