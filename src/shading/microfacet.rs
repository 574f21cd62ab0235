//! Rough surfaces as mirrors of many small facets, with the GGX distribution of normals (Walter et al. 2007).

use crate::lanes::{Lanes, V3, circle};

/// Maps a point (a, b) of the unit square to a facet, as its unit normal, among those of a surface of width `alpha` that
/// are visible from the direction `to_eye` (unit, on the side of the unit normal `ns`): the reflections are uniform on a
/// spherical cap (Dupuy and Benyoub, Sampling Visible GGX Normals with Spherical Caps, 2023).
#[inline(always)]
pub fn visible_facet<L: Lanes>(s: L::Simd, ns: V3<L>, to_eye: V3<L>, alpha: L, [a, b]: [L; 2]) -> V3<L> {
    let (zero, one) = (L::lit(s, 0.0), L::lit(s, 1.0));
    let [right, up] = ns.across(s);
    // The direction to the eye, where the surface is stretched to a hemisphere.
    let eye = V3 { x: to_eye.dot(right) * alpha, y: to_eye.dot(up) * alpha, z: to_eye.dot(ns).max(zero) }.normalized(s);
    let z = (one - b) * (one + eye.z) - eye.z;
    let reach = (one - z * z).max(zero).sqrt();
    let [x, y] = circle(s, a);
    let half = V3 { x: x * reach + eye.x, y: y * reach + eye.y, z: z + eye.z };
    let facet = V3 { x: half.x * alpha, y: half.y * alpha, z: half.z.max(L::lit(s, 1e-12)) };
    (right * facet.x + up * facet.y + ns * facet.z).normalized(s)
}

/// Share of the light in a unit direction that other facets do not hide: Smith's
/// G1 = 2 / (1 + sqrt(1 + alpha^2 tan^2)). It is the weight of a ray that leaves from a facet visible to the eye.
#[inline(always)]
pub fn smith_g1<L: Lanes>(s: L::Simd, ns: V3<L>, dir: V3<L>, alpha: L) -> L {
    let one = L::lit(s, 1.0);
    let cos = ns.dot(dir).abs();
    let across = alpha * alpha * (one - cos * cos).max(L::lit(s, 0.0));
    (cos + cos) / (cos + (cos * cos + across).sqrt())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math;

    /// The share of a hemisphere's light that a rough mirror reflects, by its definition: the integral of
    /// G1(v) G1(l) D(m) / (4 n.v) over all l, where D is the distribution of facets.
    fn albedo(cos: f64, alpha: f64) -> f64 {
        let sine = (1.0 - cos * cos).sqrt();
        let g1 = |c: f64| 2.0 * c / (c + (c * c + alpha * alpha * (1.0 - c * c)).sqrt());
        let (rows, columns) = (2000, 400);
        let mut sum = 0.0;
        for row in 0..rows {
            let z = (f64::from(row) + 0.5) / f64::from(rows);
            for column in 0..columns {
                let angle = (f64::from(column) + 0.5) / f64::from(columns) * std::f64::consts::PI;
                let (_, c) = math::sin_cos(angle);
                let (x, r) = (c, (1.0 - z * z).sqrt());
                // m is halfway between v = (sine, 0, cos) and l.
                let (mx, mz) = (sine + r * x, cos + z);
                let my = r * math::sin_cos(angle).0;
                let length = (mx * mx + my * my + mz * mz).sqrt();
                let mz = mz / length;
                let d = mz * mz * (alpha * alpha - 1.0) + 1.0;
                let d = alpha * alpha / (std::f64::consts::PI * d * d);
                sum += d * g1(cos) * g1(z) / (4.0 * cos);
            }
        }
        sum * 2.0 * std::f64::consts::PI / f64::from(rows * columns)
    }

    #[test]
    fn chosen_facets_reflect_as_much_as_the_integral_says() {
        let ns = V3 { x: 0.0, y: 0.0, z: 1.0 };
        for (cos, alpha) in [(0.9f64, 0.25), (0.5, 0.5), (0.3, 0.8), (1.0, 0.64)] {
            let eye = V3 { x: (1.0 - cos * cos).sqrt(), y: 0.0, z: cos };
            let n = 256;
            let mut sum = 0.0;
            for i in 0..n * n {
                let point = [(f64::from(i % n) + 0.5) / f64::from(n), (f64::from(i / n) + 0.5) / f64::from(n)];
                let m = visible_facet((), ns, eye, alpha, point);
                assert!((m.dot(m) - 1.0).abs() < 1e-12);
                let out = m * (2.0 * m.dot(eye)) - eye;
                sum += if out.z > 0.0 { smith_g1((), ns, out, alpha) } else { 0.0 };
            }
            let (got, expected) = (sum / f64::from(n * n), albedo(cos, alpha));
            assert!((got - expected).abs() < 2e-3, "cos {cos}, alpha {alpha}: {got} instead of {expected}");
        }
    }

    #[test]
    fn a_smooth_surface_has_one_facet() {
        let ns = V3 { x: 0.6, y: 0.0, z: 0.8 };
        let eye = V3 { x: 0.0, y: 0.6, z: 0.8 };
        let m = visible_facet((), ns, eye, 0.0, [0.3, 0.7]);
        assert!((m.dot(ns) - 1.0).abs() < 1e-15);
        assert_eq!(smith_g1((), ns, eye, 0.0), 1.0);
    }
}
