//! Indices: of triangles (mode 1), and any (mode 2).

use super::super::budget::worked;
use super::{CANCELLED, Decoded, Stream, TOO_SHORT, unzigzag};

/// The last sixteen of something; what has not been written yet is a whole number of ones, which no index is.
struct Fifo<T>([T; 16], usize);

impl<T: Copy> Fifo<T> {
    fn push(&mut self, value: T) {
        self.0[self.1 & 15] = value;
        self.1 += 1;
    }

    /// The value so many before the last.
    fn get(&self, back: u8) -> T {
        self.0[self.1.wrapping_sub(1 + usize::from(back)) & 15]
    }
}

/// Writes indices of two or four bytes.
struct Indices {
    bytes: Vec<u8>,
    size: usize,
}

impl Indices {
    fn new(count: usize, size: usize) -> Result<Self, &'static str> {
        if size != 2 && size != 4 {
            return Err("have indices of neither 2 nor 4 bytes");
        }
        Ok(Self { bytes: Vec::with_capacity(count * size), size })
    }

    fn push(&mut self, index: u32) {
        self.bytes.extend_from_slice(&index.to_le_bytes()[..self.size]);
    }
}

/// Indices of triangles, most of which share an edge with one shortly before.
pub(in crate::models) fn triangles(packed: &[u8], count: usize, size: usize) -> Decoded {
    if !count.is_multiple_of(3) {
        return Err("have a number of indices that is no multiple of 3");
    }
    let mut indices = Indices::new(count, size)?;
    let mut stream = Stream(packed);
    if stream.byte()? != 0xe1 {
        return Err("do not begin with 0xe1");
    }
    let codes = stream.take(count / 3)?;
    let (data, table) = stream.0.split_at_checked(stream.0.len().checked_sub(16).ok_or(TOO_SHORT)?).ok_or(TOO_SHORT)?;
    let mut state = Triangles {
        data: Stream(data),
        next: 0,
        last: 0,
        edges: Fifo([[u32::MAX; 2]; 16], 0),
        vertices: Fifo([u32::MAX; 16], 0),
    };
    for (i, &code) in codes.iter().enumerate() {
        if i % 4_096 == 0 {
            worked(4_096).map_err(|_| CANCELLED)?;
        }
        state.triangle(code, table)?.into_iter().for_each(|index| indices.push(index));
    }
    if state.data.0.is_empty() { Ok(indices.bytes) } else { Err("go on after the last triangle") }
}

/// What a decoder of triangles remembers.
struct Triangles<'a> {
    data: Stream<'a>,
    next: u32,
    last: u32,
    edges: Fifo<[u32; 2]>,
    vertices: Fifo<u32>,
}

impl Triangles<'_> {
    fn take_next(&mut self) -> u32 {
        let index = self.next;
        self.next = self.next.wrapping_add(1);
        index
    }

    fn explicit(&mut self) -> Result<u32, &'static str> {
        self.last = self.last.wrapping_add(unzigzag(self.data.varint()?));
        Ok(self.last)
    }

    fn triangle(&mut self, code: u8, table: &[u8]) -> Result<[u32; 3], &'static str> {
        if code < 0xf0 {
            return self.at_an_edge(code >> 4, code & 15);
        }
        let (aux, first_is_next) = match code {
            0xfe | 0xff => (self.data.byte()?, code == 0xfe),
            _ => (table[usize::from(code & 15)], true),
        };
        let is_explicit = code >= 0xfe;
        if is_explicit && aux == 0 {
            self.next = 0;
        }
        let (of_b, of_c) = (aux >> 4, aux & 15);
        // Those that come next are numbered before those that are written out.
        let a = first_is_next.then(|| self.take_next());
        let mut numbered = |code: u8| match code {
            0 => Some(self.take_next()),
            15 if is_explicit => None,
            code => Some(self.vertices.get(code - 1)),
        };
        let (b, c) = (numbered(of_b), numbered(of_c));
        let a = a.map_or_else(|| self.explicit(), Ok)?;
        let b = b.map_or_else(|| self.explicit(), Ok)?;
        let c = c.map_or_else(|| self.explicit(), Ok)?;
        self.vertices.push(a);
        [(of_b, b), (of_c, c)]
            .into_iter()
            .filter(|(code, _)| *code == 0 || (is_explicit && *code == 15))
            .for_each(|(_, vertex)| self.vertices.push(vertex));
        self.edges.push([b, a]);
        self.edges.push([c, b]);
        self.edges.push([a, c]);
        Ok([a, b, c])
    }

    fn at_an_edge(&mut self, edge: u8, third: u8) -> Result<[u32; 3], &'static str> {
        let [a, b] = self.edges.get(edge);
        let c = match third {
            0 => self.take_next(),
            1..13 => self.vertices.get(third),
            13 | 14 => {
                self.last = if third == 13 { self.last.wrapping_sub(1) } else { self.last.wrapping_add(1) };
                self.last
            }
            _ => self.explicit()?,
        };
        if !(1..13).contains(&third) {
            self.vertices.push(c);
        }
        self.edges.push([c, b]);
        self.edges.push([a, c]);
        Ok([a, b, c])
    }
}

/// Any indices, as differences from one of two before.
pub(in crate::models) fn indices(packed: &[u8], count: usize, size: usize) -> Decoded {
    let mut indices = Indices::new(count, size)?;
    let mut stream = Stream(packed);
    if stream.byte()? != 0xd1 {
        return Err("do not begin with 0xd1");
    }
    stream.0 = &stream.0[..stream.0.len().checked_sub(4).ok_or(TOO_SHORT)?];
    let mut last = [0_u32; 2];
    for i in 0..count {
        if i % 4_096 == 0 {
            worked(4_096).map_err(|_| CANCELLED)?;
        }
        let number = stream.varint()?;
        let base = &mut last[(number & 1) as usize];
        *base = base.wrapping_add(unzigzag(number >> 1));
        indices.push(*base);
    }
    if stream.0.is_empty() { Ok(indices.bytes) } else { Err("go on after the last index") }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn two_triangles_share_an_edge() {
        // The first takes three new vertices; the second its last edge but one, and the next vertex.
        let mut packed = vec![0xe1, 0xf0, 0x10];
        packed.extend([0; 16]);
        let indices = triangles(&packed, 6, 2).unwrap();
        let indices: Vec<_> = indices.chunks(2).map(|index| index[0]).collect();
        assert_eq!(indices, [0, 1, 2, 2, 1, 3]);
        for end in 0..packed.len() {
            assert!(triangles(&packed[..end], 6, 2).is_err());
        }
    }
}
