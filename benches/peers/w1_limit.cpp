// What is possible at all where a scene is tiny (W1): no hierarchy; camera, brute-force intersection, shadows, Phong,
// recursion and sRGB in loops over 16 lanes that the compiler vectorises. The rules are those of the POV-Ray scene.
//
// usage: w1_limit SCENE.bin THREADS REPS [OUT.ppm]      Prints "TIME seconds", the median of the renders.
#include <algorithm>
#include <atomic>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <thread>
#include <vector>
using std::vector;
enum { K = 16 };
struct V {
    float x, y, z;
};
struct alignas(64) F {
    float v[K];
    float& operator[](int i) { return v[i]; }
    float operator[](int i) const { return v[i]; }
};
struct Mat {
    V c1, c2;
    float size, amb, kd, ks, shine, kr, kt, ior, pad;
};
struct Light {
    V p, c;
};
static unsigned w, h, depth;
static float adc;
static V eye, dir, R, U, bg;
static vector<Light> L;
static vector<Mat> M;
enum { MAXO = 16 };
static int ns, nt;
static float sx[MAXO], sy[MAXO], sz[MAXO], sr[MAXO];
static int om[2 * MAXO];
struct Tri {
    V a, e1, e2, n;
} tri[MAXO];
static float tb[20][2 * MAXO];  // per object: cx cy cz 1/r | nx ny nz | c1 c2 | 1/size amb kd ks shine kr kt
static V sub(V a, V b) { return {a.x - b.x, a.y - b.y, a.z - b.z}; }
static V cross(V a, V b) { return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x}; }
static double now() {
    return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}
static void load(const char* p) {
    FILE* f = fopen(p, "rb");
    char m[4];
    unsigned q[7];
    auto rd = [&](void* d, size_t n) {
        if (n && fread(d, 1, n, f) != n) exit(1);
    };
    rd(m, 4);
    rd(q, 28);
    rd(&adc, 4);
    w = q[0];
    h = q[1];
    depth = q[2];
    L.resize(q[3]);
    M.resize(q[4]);
    rd(&eye, 12);
    rd(&dir, 12);
    rd(&R, 12);
    rd(&U, 12);
    rd(&bg, 12);
    rd(L.data(), 24 * q[3]);
    rd(M.data(), 60 * q[4]);
    ns = q[5];
    if (ns > MAXO) exit(2);
    for (int i = 0; i < ns; i++) {
        float s[4];
        rd(s, 16);
        sx[i] = s[0];
        sy[i] = s[1];
        sz[i] = s[2];
        sr[i] = s[3];
    }
    unsigned k;
    for (int i = 0; i < ns; i++) {
        rd(&k, 4);
        om[i] = k;
    }
    for (unsigned e = 0; e < q[6]; e++) {
        unsigned k[4];
        rd(k, 16);
        vector<V> v(k[0]);
        vector<unsigned> id(3 * k[1]);
        rd(v.data(), 12 * k[0]);
        if (k[2]) exit(2);
        rd(id.data(), 12 * k[1]);
        for (unsigned j = 0; j < k[1]; j++) {
            V a = v[id[3 * j]], b = v[id[3 * j + 1]], c = v[id[3 * j + 2]];
            Tri t{a, sub(b, a), sub(c, a), {}};
            V n = cross(t.e1, t.e2);
            float l = 1 / sqrtf(n.x * n.x + n.y * n.y + n.z * n.z);
            t.n = {n.x * l, n.y * l, n.z * l};
            om[ns + nt] = k[3];
            tri[nt++] = t;
        }
    }
    for (int i = 0; i < ns + nt; i++) {
        const Mat& a = M[om[i]];
        float g[18] = {i < ns ? sx[i] : 0,
                       i < ns ? sy[i] : 0,
                       i < ns ? sz[i] : 0,
                       i < ns ? 1 / sr[i] : 0,
                       i < ns ? 0 : tri[i - ns].n.x,
                       i < ns ? 0 : tri[i - ns].n.y,
                       i < ns ? 0 : tri[i - ns].n.z,
                       a.c1.x,
                       a.c1.y,
                       a.c1.z,
                       a.c2.x,
                       a.c2.y,
                       a.c2.z,
                       a.size > 0 ? 1 / a.size : 0,
                       a.amb,
                       a.kd,
                       a.ks,
                       a.shine};
        for (int j = 0; j < 18; j++) tb[j][i] = g[j];
        tb[18][i] = a.kr;
        tb[19][i] = a.kt;
    }
}
#define EACH for (int i = 0; i < K; i++)
struct P {
    F ox, oy, oz, dx, dy, dz, wt;
    int on[K];
};
static void trace(const P& p, int level, F& cr, F& cg, F& cb) {
    alignas(64) F t;
    alignas(64) int id[K];
    const float E = 1e-4f;
    EACH {
        t[i] = p.on[i] ? 1e30f : 0.f;
        id[i] = -1;
    }
    for (int k = 0; k < ns; k++) {
        float X = sx[k], Y = sy[k], Z = sz[k], r2 = sr[k] * sr[k];
        EACH {
            float a = X - p.ox[i], b = Y - p.oy[i], c = Z - p.oz[i], q = a * p.dx[i] + b * p.dy[i] + c * p.dz[i];
            float ex = a - q * p.dx[i], ey = b - q * p.dy[i], ez = c - q * p.dz[i],
                  D = r2 - ex * ex - ey * ey - ez * ez;
            float s = sqrtf(D > 0 ? D : 0), t0 = q - s, t1 = q + s, tt = t0 > E ? t0 : t1;
            bool ok = (D > 0) & (tt > E) & (tt < t[i]);
            t[i] = ok ? tt : t[i];
            id[i] = ok ? k : id[i];
        }
    }
    for (int k = 0; k < nt; k++) {
        const Tri g = tri[k];
        EACH {
            float dx = p.dx[i], dy = p.dy[i], dz = p.dz[i];
            float px = dy * g.e2.z - dz * g.e2.y, py = dz * g.e2.x - dx * g.e2.z, pz = dx * g.e2.y - dy * g.e2.x,
                  det = g.e1.x * px + g.e1.y * py + g.e1.z * pz, inv = 1 / det;
            float a = p.ox[i] - g.a.x, b = p.oy[i] - g.a.y, c = p.oz[i] - g.a.z, u = (a * px + b * py + c * pz) * inv;
            float qx = b * g.e1.z - c * g.e1.y, qy = c * g.e1.x - a * g.e1.z, qz = a * g.e1.y - b * g.e1.x;
            float v = (dx * qx + dy * qy + dz * qz) * inv, tt = (g.e2.x * qx + g.e2.y * qy + g.e2.z * qz) * inv;
            bool ok = (u >= 0) & (v >= 0) & (u + v <= 1) & (tt > E) & (tt < t[i]);
            t[i] = ok ? tt : t[i];
            id[i] = ok ? ns + k : id[i];
        }
    }
    F x, y, z, nx, ny, nz, pr, pg, pb, ks, kd, kr, kt, shn;
    alignas(64) int hit[K], ins[K];
    int any = 0;
    EACH {
        int o = id[i] < 0 ? 0 : id[i];
        hit[i] = id[i] >= 0;
        any |= hit[i];
        t[i] = hit[i] ? t[i] : 0.f;
        x[i] = p.ox[i] + p.dx[i] * t[i];
        y[i] = p.oy[i] + p.dy[i] * t[i];
        z[i] = p.oz[i] + p.dz[i] * t[i];
        float ir = tb[3][o], a = (x[i] - tb[0][o]) * ir + tb[4][o], b = (y[i] - tb[1][o]) * ir + tb[5][o],
              c = (z[i] - tb[2][o]) * ir + tb[6][o];
        bool in = a * p.dx[i] + b * p.dy[i] + c * p.dz[i] > 0;
        ins[i] = in;
        float s = in ? -1.f : 1.f;
        nx[i] = a * s;
        ny[i] = b * s;
        nz[i] = c * s;
        float is = tb[13][o];
        int ck = ((int)floorf(x[i] * is) + (int)floorf(z[i] * is)) & 1;
        ck = is > 0 ? ck : 0;
        pr[i] = ck ? tb[10][o] : tb[7][o];
        pg[i] = ck ? tb[11][o] : tb[8][o];
        pb[i] = ck ? tb[12][o] : tb[9][o];
        kd[i] = tb[15][o];
        ks[i] = tb[16][o];
        shn[i] = tb[17][o];
        kr[i] = hit[i] ? tb[18][o] : 0;
        kt[i] = hit[i] ? tb[19][o] : 0;
        float am = tb[14][o];
        cr[i] = hit[i] ? pr[i] * am : bg.x;
        cg[i] = hit[i] ? pg[i] * am : bg.y;
        cb[i] = hit[i] ? pb[i] * am : bg.z;
    }
    if (!any) return;
    for (auto& l : L) {
        F lx, ly, lz, ld, vis, nl;
        int cnt = 0;
        EACH {
            float a = l.p.x - x[i], b = l.p.y - y[i], c = l.p.z - z[i], d2 = a * a + b * b + c * c, r = 1 / sqrtf(d2);
            lx[i] = a * r;
            ly[i] = b * r;
            lz[i] = c * r;
            ld[i] = d2 * r;
            nl[i] = lx[i] * nx[i] + ly[i] * ny[i] + lz[i] * nz[i];
            int s = hit[i] & (nl[i] > 0);
            vis[i] = s ? 1.f : 0.f;
            cnt += s;
        }
        if (!cnt) continue;
        for (int k = 0; k < ns; k++) {
            float X = sx[k], Y = sy[k], Z = sz[k], r2 = sr[k] * sr[k], T = M[om[k]].kt;
            EACH {
                float a = X - x[i], b = Y - y[i], c = Z - z[i], q = a * lx[i] + b * ly[i] + c * lz[i];
                float ex = a - q * lx[i], ey = b - q * ly[i], ez = c - q * lz[i], D = r2 - ex * ex - ey * ey - ez * ez,
                      s = sqrtf(D > 0 ? D : 0);
                vis[i] *= (D > 0) & (q - s > E) & (q - s < ld[i]) ? T : 1.f;
                vis[i] *= (D > 0) & (q + s > E) & (q + s < ld[i]) ? T : 1.f;
            }
        }
        for (int k = 0; k < nt; k++) {
            const Tri g = tri[k];
            float T = M[om[ns + k]].kt;
            EACH {
                float dx = lx[i], dy = ly[i], dz = lz[i];
                float px = dy * g.e2.z - dz * g.e2.y, py = dz * g.e2.x - dx * g.e2.z, pz = dx * g.e2.y - dy * g.e2.x,
                      inv = 1 / (g.e1.x * px + g.e1.y * py + g.e1.z * pz);
                float a = x[i] - g.a.x, b = y[i] - g.a.y, c = z[i] - g.a.z, u = (a * px + b * py + c * pz) * inv;
                float qx = b * g.e1.z - c * g.e1.y, qy = c * g.e1.x - a * g.e1.z, qz = a * g.e1.y - b * g.e1.x;
                float v = (dx * qx + dy * qy + dz * qz) * inv, tt = (g.e2.x * qx + g.e2.y * qy + g.e2.z * qz) * inv;
                vis[i] *= (u >= 0) & (v >= 0) & (u + v <= 1) & (tt > E) & (tt < ld[i]) ? T : 1.f;
            }
        }
        EACH {
            float dn = 2 * (p.dx[i] * nx[i] + p.dy[i] * ny[i] + p.dz[i] * nz[i]);
            float rl = (p.dx[i] - dn * nx[i]) * lx[i] + (p.dy[i] - dn * ny[i]) * ly[i] + (p.dz[i] - dn * nz[i]) * lz[i];
            float s = rl > 0 ? ks[i] * exp2f(shn[i] * log2f(rl > 1e-20f ? (rl < 1 ? rl : 1.f) : 1e-20f)) : 0.f,
                  d = kd[i] * nl[i], q = vis[i];
            cr[i] += q * l.c.x * (pr[i] * d + s);
            cg[i] += q * l.c.y * (pg[i] * d + s);
            cb[i] += q * l.c.z * (pb[i] * d + s);
        }
    }
    if (level >= (int)depth) return;
    P r, q;
    F fr, ft;
    int nr = 0, nq = 0;
    EACH {
        float c = -(p.dx[i] * nx[i] + p.dy[i] * ny[i] + p.dz[i] * nz[i]);
        float ior = 1.5f, e = ins[i] ? ior : 1 / ior, k = 1 - e * e * (1 - c * c);
        bool tir = (k < 0) & (kt[i] > 0);
        float a = kr[i] + (tir ? kt[i] : 0.f), b = tir ? 0.f : kt[i];
        r.ox[i] = x[i];
        r.oy[i] = y[i];
        r.oz[i] = z[i];
        r.dx[i] = p.dx[i] + 2 * c * nx[i];
        r.dy[i] = p.dy[i] + 2 * c * ny[i];
        r.dz[i] = p.dz[i] + 2 * c * nz[i];
        fr[i] = a;
        r.wt[i] = p.wt[i] * a;
        r.on[i] = (a > 0) & (r.wt[i] >= adc);
        nr += r.on[i];
        float m = e * c - sqrtf(k > 0 ? k : 0);
        float tx = p.dx[i] * e + nx[i] * m, ty = p.dy[i] * e + ny[i] * m, tz = p.dz[i] * e + nz[i] * m;
        float inv = 1 / sqrtf(tx * tx + ty * ty + tz * tz + 1e-30f);
        q.ox[i] = x[i];
        q.oy[i] = y[i];
        q.oz[i] = z[i];
        q.dx[i] = tx * inv;
        q.dy[i] = ty * inv;
        q.dz[i] = tz * inv;
        ft[i] = b;
        q.wt[i] = p.wt[i] * b;
        q.on[i] = (b > 0) & (q.wt[i] >= adc);
        nq += q.on[i];
    }
    F a, b, c;
    if (nr) {
        trace(r, level + 1, a, b, c);
        EACH {
            float f = r.on[i] ? fr[i] : 0.f;
            cr[i] += f * a[i];
            cg[i] += f * b[i];
            cb[i] += f * c[i];
        }
    }
    if (nq) {
        trace(q, level + 1, a, b, c);
        EACH {
            float f = q.on[i] ? ft[i] : 0.f;
            cr[i] += f * a[i];
            cg[i] += f * b[i];
            cb[i] += f * c[i];
        }
    }
}
int main(int count, char** v) {
    if (count < 4) {
        fprintf(stderr, "usage: w1_limit SCENE.bin THREADS REPS [OUT.ppm]\n");
        return 2;
    }
    load(v[1]);
    int th = atoi(v[2]), reps = atoi(v[3]);
    vector<unsigned char> img((size_t)w * h * 3);
    static unsigned char lut[4097];
    for (int i = 0; i <= 4096; i++) {
        float x = i / 4096.f;
        lut[i] = (unsigned char)(255 * (x <= .0031308f ? 12.92f * x : 1.055f * powf(x, 1 / 2.4f) - .055f) + .5f);
    }
    vector<double> T;
    for (int q = 0; q < reps; q++) {
        std::atomic<int> row{0};
        double t0 = now();
        auto run = [&] {
            for (int y; (y = 4 * row++) < (int)h;)
                for (int x = 0; x < (int)w; x += 4) {
                    P p;
                    F r, g, bb;
                    EACH {
                        float X = x + (i & 3) + .5f, Y = y + (i >> 2) + .5f, s = 2 * X / w - 1, u = 1 - 2 * Y / h;
                        float dx = dir.x + R.x * s + U.x * u, dy = dir.y + R.y * s + U.y * u,
                              dz = dir.z + R.z * s + U.z * u, inv = 1 / sqrtf(dx * dx + dy * dy + dz * dz);
                        p.ox[i] = eye.x;
                        p.oy[i] = eye.y;
                        p.oz[i] = eye.z;
                        p.dx[i] = dx * inv;
                        p.dy[i] = dy * inv;
                        p.dz[i] = dz * inv;
                        p.wt[i] = 1;
                        p.on[i] = 1;
                    }
                    trace(p, 1, r, g, bb);
                    for (int i = 0; i < K; i++) {
                        unsigned char* d = &img[3 * ((size_t)(y + (i >> 2)) * w + x + (i & 3))];
                        d[0] = lut[(int)(std::min(1.f, std::max(0.f, r[i])) * 4096)];
                        d[1] = lut[(int)(std::min(1.f, std::max(0.f, g[i])) * 4096)];
                        d[2] = lut[(int)(std::min(1.f, std::max(0.f, bb[i])) * 4096)];
                    }
                }
        };
        vector<std::thread> tt;
        for (int i = 1; i < th; i++) tt.emplace_back(run);
        run();
        for (auto& t : tt) t.join();
        T.push_back(now() - t0);
    }
    std::sort(T.begin(), T.end());
    double m = T[T.size() / 2];
    printf("TIME %.5f\n", m);
    if (count > 4) {
        FILE* f = fopen(v[4], "wb");
        fprintf(f, "P6\n%u %u\n255\n", w, h);
        fwrite(img.data(), 1, img.size(), f);
        fclose(f);
    }
}
