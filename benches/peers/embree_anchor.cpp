// A complete Whitted renderer on Embree 4: our own, and the strongest opponent we could write. Packets of 16 rays,
// shading, contribution cut-off and depth as in the POV-Ray scenes, shadows through glass in one traversal.
//
// usage: embree_anchor SCENE.bin THREADS hybrid|single|packet [REPS] [OUT.ppm]
//   hybrid: packets, but single rays where at most three lanes live; single and packet: only those.
// Prints "TIME seconds", the median of the renders without the hierarchy's build.
#include <algorithm>
#include <atomic>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <functional>
#include <string>
#include <thread>
#include <vector>

#include "embree4_min.h"
static void I1(RTCScene s, void* r, Args* a) { rtcIntersect1(s, r, a); }
static void O1(RTCScene s, void* r, Args* a) { rtcOccluded1(s, r, a); }
static void I(const int* v, RTCScene s, RayHitT<16>* r, Args* a) { rtcIntersect16(v, s, r, a); }
static void O(const int* v, RTCScene s, RayT<16>* r, Args* a) { rtcOccluded16(v, s, r, a); }
// Arguments for coherent rays, or for others.
static Args mk(bool coh) { return Args{coh ? 1 << 16 : 0, -1, nullptr, nullptr, nullptr}; }
using std::vector;
struct V {
    float x, y, z;
};
static inline V operator+(V a, V b) { return {a.x + b.x, a.y + b.y, a.z + b.z}; }
static inline V operator-(V a, V b) { return {a.x - b.x, a.y - b.y, a.z - b.z}; }
static inline V operator*(V a, float s) { return {a.x * s, a.y * s, a.z * s}; }
static inline V operator*(V a, V b) { return {a.x * b.x, a.y * b.y, a.z * b.z}; }
static inline float dot(V a, V b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
static inline V norm(V a) { return a * (1 / sqrtf(dot(a, a))); }
struct Mat {
    V c1, c2;
    float size, amb, kd, ks, shine, kr, kt, ior, pad;
};
struct Light {
    V p, c;
};
struct Mesh {
    vector<V> v, n;
    vector<unsigned> f;
    unsigned mat;
};
struct S4 {
    float x, y, z, r;
};
struct Scene {
    unsigned w, h, depth;
    float adc;
    V eye, dir, R, U, bg;
    vector<Light> L;
    vector<Mat> M;
    vector<S4> sph;
    vector<unsigned> sm;
    vector<Mesh> me;
    bool glass = false;
} S;
static double now() {
    return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}
static void load(const char* p) {
    FILE* f = fopen(p, "rb");
    if (!f) {
        perror(p);
        exit(1);
    }
    char m[4];
    unsigned q[7];
    auto rd = [&](void* d, size_t n) {
        if (fread(d, 1, n, f) != n) {
            fprintf(stderr, "short\n");
            exit(1);
        }
    };
    rd(m, 4);
    rd(q, 28);
    rd(&S.adc, 4);
    S.w = q[0];
    S.h = q[1];
    S.depth = q[2];
    S.L.resize(q[3]);
    S.M.resize(q[4]);
    S.sph.resize(q[5]);
    S.sm.resize(q[5]);
    S.me.resize(q[6]);
    rd(&S.eye, 12);
    rd(&S.dir, 12);
    rd(&S.R, 12);
    rd(&S.U, 12);
    rd(&S.bg, 12);
    rd(S.L.data(), 24 * q[3]);
    static_assert(sizeof(Mat) == 60, "");
    rd(S.M.data(), 60 * q[4]);
    rd(S.sph.data(), 16 * q[5]);
    rd(S.sm.data(), 4 * q[5]);
    for (auto& e : S.me) {
        unsigned k[4];
        rd(k, 16);
        e.v.resize(k[0]);
        e.f.resize(3 * k[1]);
        e.mat = k[3];
        rd(e.v.data(), 12 * k[0]);
        if (k[2]) {
            e.n.resize(k[0]);
            rd(e.n.data(), 12 * k[0]);
        }
        rd(e.f.data(), 12 * k[1]);
    }
    for (auto& a : S.M) S.glass |= a.kt > 0;
    fclose(f);
}
static RTCScene build(RTCDevice d) {
    const RTCBuildQuality q = RTC_BUILD_QUALITY_MEDIUM;
    RTCScene sc = rtcNewScene(d);
    rtcSetSceneBuildQuality(sc, q);
    for (auto& e : S.me) {
        RTCGeometry g = rtcNewGeometry(d, RTC_GEOMETRY_TYPE_TRIANGLE);
        rtcSetGeometryBuildQuality(g, q);
        memcpy(rtcSetNewGeometryBuffer(g, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, 12, e.v.size()), e.v.data(),
               12 * e.v.size());
        memcpy(rtcSetNewGeometryBuffer(g, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, 12, e.f.size() / 3), e.f.data(),
               4 * e.f.size());
        rtcCommitGeometry(g);
        rtcAttachGeometry(sc, g);
        rtcReleaseGeometry(g);
    }
    if (S.sph.size()) {
        RTCGeometry g = rtcNewGeometry(d, RTC_GEOMETRY_TYPE_SPHERE_POINT);
        rtcSetGeometryBuildQuality(g, q);
        memcpy(rtcSetNewGeometryBuffer(g, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT4, 16, S.sph.size()), S.sph.data(),
               16 * S.sph.size());
        rtcCommitGeometry(g);
        rtcAttachGeometry(sc, g);
        rtcReleaseGeometry(g);
    }
    rtcCommitScene(sc);
    return sc;
}
static void tiles(int threads, const std::function<void(int x0, int y0, int x1, int y1)>& fn) {
    const int T = 32;
    int nx = (S.w + T - 1) / T, ny = (S.h + T - 1) / T;
    std::atomic<int> k{0};
    auto run = [&] {
        for (int i; (i = k++) < nx * ny;) {
            int x = i % nx * T, y = i / nx * T;
            fn(x, y, std::min<int>(x + T, S.w), std::min<int>(y + T, S.h));
        }
    };
    vector<std::thread> th;
    for (int i = 1; i < threads; i++) th.emplace_back(run);
    run();
    for (auto& t : th) t.join();
}
static inline V raydir(float x, float y) {
    return norm(S.dir + S.R * (2 * (x + .5f) / S.w - 1) + S.U * (1 - 2 * (y + .5f) / S.h));
}
template <int N>
static inline void setray(RayT<N>& r, int i, V o, V d, float tn, float tf) {
    r.org_x[i] = o.x;
    r.org_y[i] = o.y;
    r.org_z[i] = o.z;
    r.dir_x[i] = d.x;
    r.dir_y[i] = d.y;
    r.dir_z[i] = d.z;
    r.tnear[i] = tn;
    r.tfar[i] = tf;
    r.time[i] = 0;
    r.mask[i] = ~0u;
    r.id[i] = i;
    r.flags[i] = 0;
}
static inline float epsAt(V p) { return 2e-5f * std::max({1.f, fabsf(p.x), fabsf(p.y), fabsf(p.z)}); }
// ---------------- complete Whitted renderer, packets of 16 ----------------
struct P16 {
    int valid[16];
    V o[16], d[16];
    float w[16];
};
static RTCScene SC;
static int KMIN;  // lanes <= KMIN use the single-ray calls
struct FArgs {
    int* valid;
    void *user, *ctx;
    unsigned *ray, *hit;
    unsigned N;
};
static thread_local float *fvis, *fw;
static const Mat& matOf2(unsigned g, unsigned p) { return S.M[g < S.me.size() ? S.me[g].mat : S.sm[p]]; }
static void shadowFilter(const FArgs* a) {
    unsigned N = a->N;
    for (unsigned i = 0; i < N; i++)
        if (a->valid[i]) {
            unsigned id = a->ray[10 * N + i];
            float v = fvis[id] *= matOf2(a->hit[6 * N + i], a->hit[5 * N + i]).kt;
            if (v * fw[id] < S.adc) {
                if (v < S.adc) fvis[id] = 0;
            } else
                a->valid[i] = 0;
        }
}
static inline int popc(const int* v) {
    int n = 0;
    for (int i = 0; i < 16; i++) n += v[i] != 0;
    return n;
}
static void closest(const int* valid, RayHitT<16>& r, Args* a) {
    int n = popc(valid);
    if (n > KMIN) {
        I(valid, SC, &r, a);
        return;
    }
    for (int i = 0; i < 16; i++)
        if (valid[i]) {
            RayHitT<1> s;
            setray<1>(s.ray, 0, {r.ray.org_x[i], r.ray.org_y[i], r.ray.org_z[i]},
                      {r.ray.dir_x[i], r.ray.dir_y[i], r.ray.dir_z[i]}, r.ray.tnear[i], r.ray.tfar[i]);
            s.hit.geomID[0] = ~0u;
            s.hit.instID[0] = ~0u;
            I1(SC, &s, a);
            r.ray.tfar[i] = s.ray.tfar[0];
            r.hit.u[i] = s.hit.u[0];
            r.hit.v[i] = s.hit.v[0];
            r.hit.geomID[i] = s.hit.geomID[0];
            r.hit.primID[i] = s.hit.primID[0];
            r.hit.Ng_x[i] = s.hit.Ng_x[0];
            r.hit.Ng_y[i] = s.hit.Ng_y[0];
            r.hit.Ng_z[i] = s.hit.Ng_z[0];
        }
}
static inline const Mat& matOf(unsigned g, unsigned p) { return S.M[g < S.me.size() ? S.me[g].mat : S.sm[p]]; }
static void trace(P16& p, int level, V* out) {
    alignas(64) RayHitT<16> rh;
    alignas(64) int val[16];
    Args a = mk(level == 1);
    for (int i = 0; i < 16; i++) {
        val[i] = p.valid[i];
        setray<16>(rh.ray, i, p.o[i], p.d[i], 0, p.valid[i] ? 1e30f : -1.f);
        rh.hit.geomID[i] = ~0u;
        rh.hit.instID[i] = ~0u;
        out[i] = {0, 0, 0};
    }
    closest(val, rh, &a);
    V P[16], N[16], pig[16];
    const Mat* M[16];
    float eps[16];
    for (int i = 0; i < 16; i++)
        if (val[i]) {
            unsigned g = rh.hit.geomID[i], k = rh.hit.primID[i];
            if (g == ~0u) {
                out[i] = S.bg;
                val[i] = 0;
                continue;
            }
            M[i] = &matOf(g, k);
            P[i] = p.o[i] + p.d[i] * rh.ray.tfar[i];
            eps[i] = 4 * epsAt(P[i]);
            if (g >= S.me.size()) {
                S4& s = S.sph[k];
                N[i] = (P[i] - V{s.x, s.y, s.z}) * (1 / s.r);
            } else {
                Mesh& e = S.me[g];
                if (e.n.empty())
                    N[i] = norm({rh.hit.Ng_x[i], rh.hit.Ng_y[i], rh.hit.Ng_z[i]});
                else {
                    unsigned* f = &e.f[3 * k];
                    float u = rh.hit.u[i], v = rh.hit.v[i];
                    N[i] = norm(e.n[f[0]] * (1 - u - v) + e.n[f[1]] * u + e.n[f[2]] * v);
                }
            }
            pig[i] = M[i]->size > 0 && (((int)floorf(P[i].x / M[i]->size) + (int)floorf(P[i].z / M[i]->size)) & 1)
                         ? M[i]->c2
                         : M[i]->c1;
            out[i] = pig[i] * M[i]->amb;
        }
    bool inside[16];
    for (int i = 0; i < 16; i++)
        if (val[i]) {
            inside[i] = dot(N[i], p.d[i]) > 0;
            if (inside[i]) N[i] = N[i] * -1;
        }
    for (auto& L : S.L) {
        alignas(64) int sv[16];
        alignas(64) RayHitT<16> sr;
        float vis[16];
        int any = 0;
        for (int i = 0; i < 16; i++) {
            sv[i] = 0;
            vis[i] = 1;
            V o{0, 0, 0}, d{0, 0, 1};
            if (val[i] && (M[i]->kd > 0 || M[i]->ks > 0)) {
                d = L.p - P[i];
                bool go = dot(d, N[i]) > 0;
                if (go) {
                    sv[i] = -1;
                    o = P[i] + N[i] * eps[i];
                    d = L.p - o;
                    any = 1;
                }
            }
            setray<16>(sr.ray, i, o, d, 0, sv[i] ? 1.f : -1.f);
        }
        if (!any) continue;
        alignas(64) int act[16];
        memcpy(act, sv, 64);
        if (!S.glass) {
            int n = popc(act);
            if (n > KMIN)
                O(act, SC, &sr.ray, &a);
            else
                for (int i = 0; i < 16; i++)
                    if (act[i]) {
                        RayT<1> s;
                        setray<1>(s, 0, {sr.ray.org_x[i], sr.ray.org_y[i], sr.ray.org_z[i]},
                                  {sr.ray.dir_x[i], sr.ray.dir_y[i], sr.ray.dir_z[i]}, 0, 1);
                        O1(SC, &s, &a);
                        sr.ray.tfar[i] = s.tfar[0];
                    }
            for (int i = 0; i < 16; i++)
                if (act[i] && sr.ray.tfar[i] < 0) vis[i] = 0;
        } else {
            fvis = vis;
            fw = p.w;
            Args fa = a;
            fa.flags |= 2;
            fa.filter = (void*)shadowFilter;
            int n = popc(act);
            if (n > KMIN)
                O(act, SC, &sr.ray, &fa);
            else
                for (int i = 0; i < 16; i++)
                    if (act[i]) {
                        RayT<1> s;
                        setray<1>(s, 0, {sr.ray.org_x[i], sr.ray.org_y[i], sr.ray.org_z[i]},
                                  {sr.ray.dir_x[i], sr.ray.dir_y[i], sr.ray.dir_z[i]}, 0, 1);
                        s.id[0] = i;
                        O1(SC, &s, &fa);
                    }
        }
        for (int i = 0; i < 16; i++)
            if (sv[i] && vis[i] > 0) {
                V l = norm(L.p - P[i]);
                float nl = dot(N[i], l);
                V r = p.d[i] - N[i] * (2 * dot(p.d[i], N[i]));
                float rl = dot(r, l);
                V c = pig[i] * (M[i]->kd * nl);
                if (M[i]->ks > 0 && rl > 0) {
                    float s = M[i]->ks * powf(rl, M[i]->shine);
                    c = c + V{s, s, s};
                }
                out[i] = out[i] + L.c * c * vis[i];
            }
    }
    if (level >= (int)S.depth) return;
    P16 r, t;
    int nr = 0, nt = 0;
    float fr[16], ft[16];
    for (int i = 0; i < 16; i++) {
        r.valid[i] = t.valid[i] = 0;
        r.o[i] = t.o[i] = {0, 0, 0};
        r.d[i] = t.d[i] = {0, 0, 1};
        if (!val[i]) continue;
        const Mat& m = *M[i];
        float kr = m.kr, kt = m.kt, c = -dot(p.d[i], N[i]);
        if (kt > 0) {
            float e = inside[i] ? m.ior : 1 / m.ior, k = 1 - e * e * (1 - c * c);
            if (k < 0) {
                kr += kt;
                kt = 0;
            } else if (p.w[i] * kt >= S.adc) {
                t.valid[i] = -1;
                nt++;
                t.o[i] = P[i] - N[i] * eps[i];
                t.d[i] = norm(p.d[i] * e + N[i] * (e * c - sqrtf(k)));
                t.w[i] = p.w[i] * kt;
                ft[i] = kt;
            }
        }
        if (kr > 0 && p.w[i] * kr >= S.adc) {
            r.valid[i] = -1;
            nr++;
            r.o[i] = P[i] + N[i] * eps[i];
            r.d[i] = p.d[i] + N[i] * (2 * c);
            r.w[i] = p.w[i] * kr;
            fr[i] = kr;
        }
    }
    V o[16];
    if (nr) {
        trace(r, level + 1, o);
        for (int i = 0; i < 16; i++)
            if (r.valid[i]) out[i] = out[i] + o[i] * fr[i];
    }
    if (nt) {
        trace(t, level + 1, o);
        for (int i = 0; i < 16; i++)
            if (t.valid[i]) out[i] = out[i] + o[i] * ft[i];
    }
}
static void render(int threads, vector<unsigned char>& image) {
    unsigned char lut[4097];
    for (int i = 0; i <= 4096; i++) {
        float x = i / 4096.f;
        lut[i] = (unsigned char)(255 * (x <= .0031308f ? 12.92f * x : 1.055f * powf(x, 1 / 2.4f) - .055f) + .5f);
    }
    tiles(threads, [&](int x0, int y0, int x1, int y1) {
        P16 p;
        V c[16];
        for (int y = y0; y < y1; y += 4)
            for (int x = x0; x < x1; x += 4) {
                for (int i = 0; i < 16; i++) {
                    p.valid[i] = x + i % 4 < x1 && y + i / 4 < y1 ? -1 : 0;
                    p.o[i] = S.eye;
                    p.d[i] = raydir(x + i % 4, y + i / 4);
                    p.w[i] = 1;
                }
                trace(p, 1, c);
                for (int i = 0; i < 16; i++)
                    if (p.valid[i]) {
                        unsigned char* d = &image[3 * ((size_t)(y + i / 4) * S.w + x + i % 4)];
                        float* f = &c[i].x;
                        for (int k = 0; k < 3; k++) d[k] = lut[(int)(std::min(1.f, std::max(0.f, f[k])) * 4096)];
                    }
            }
    });
}
int main(int count, char** v) {
    if (count < 4) {
        fprintf(stderr, "usage: embree_anchor SCENE.bin THREADS hybrid|single|packet [REPS] [OUT.ppm]\n");
        return 2;
    }
    load(v[1]);
    int threads = atoi(v[2]), reps = count > 4 ? atoi(v[4]) : 1;
    KMIN = v[3][0] == 's' ? 16 : v[3][0] == 'p' ? 0 : 3;
    RTCDevice d = rtcNewDevice(("threads=" + std::to_string(threads)).c_str());
    SC = build(d);
    vector<unsigned char> image((size_t)S.w * S.h * 3);
    vector<double> times;
    for (int i = 0; i < reps; i++) {
        double start = now();
        render(threads, image);
        times.push_back(now() - start);
    }
    std::sort(times.begin(), times.end());
    printf("TIME %.5f\n", times[times.size() / 2]);
    if (count > 5) {
        FILE* f = fopen(v[5], "wb");
        fprintf(f, "P6\n%u %u\n255\n", S.w, S.h);
        fwrite(image.data(), 1, image.size(), f);
        fclose(f);
    }
}
