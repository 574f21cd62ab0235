// The part of Embree 4.4's C interface that embree_anchor.cpp calls: the Python package embreex brings the library, but
// no headers.
#pragma once
#include <stddef.h>
#define RTC_INVALID_GEOMETRY_ID 0xffffffffu
struct RTCDeviceTy;
struct RTCSceneTy;
struct RTCGeometryTy;
typedef RTCDeviceTy* RTCDevice;
typedef RTCSceneTy* RTCScene;
typedef RTCGeometryTy* RTCGeometry;
enum {
    RTC_GEOMETRY_TYPE_TRIANGLE = 0,
    RTC_GEOMETRY_TYPE_SPHERE_POINT = 50,
    RTC_BUFFER_TYPE_INDEX = 0,
    RTC_BUFFER_TYPE_VERTEX = 1,
    RTC_FORMAT_UINT3 = 0x5003,
    RTC_FORMAT_FLOAT3 = 0x9003,
    RTC_FORMAT_FLOAT4 = 0x9004,
    RTC_SCENE_FLAG_ROBUST = 4
};
enum RTCBuildQuality { RTC_BUILD_QUALITY_LOW = 0, RTC_BUILD_QUALITY_MEDIUM = 1, RTC_BUILD_QUALITY_HIGH = 2 };
template <int N>
struct alignas(N == 1 ? 16 : N * 4) RayT {
    float org_x[N], org_y[N], org_z[N], tnear[N], dir_x[N], dir_y[N], dir_z[N], time[N], tfar[N];
    unsigned mask[N], id[N], flags[N];
};
template <int N>
struct alignas(N == 1 ? 16 : N * 4) HitT {
    float Ng_x[N], Ng_y[N], Ng_z[N], u[N], v[N];
    unsigned primID[N], geomID[N], instID[N], instPrimID[N];
};
template <int N>
struct RayHitT {
    RayT<N> ray;
    HitT<N> hit;
};
struct Args {
    int flags;
    int feature_mask;
    void *context, *filter, *isect;
};  // RTCIntersectArguments / RTCOccludedArguments
extern "C" {
RTCDevice rtcNewDevice(const char*);
RTCScene rtcNewScene(RTCDevice);
void rtcReleaseScene(RTCScene);
void rtcReleaseDevice(RTCDevice);
RTCGeometry rtcNewGeometry(RTCDevice, int);
void rtcReleaseGeometry(RTCGeometry);
void rtcCommitGeometry(RTCGeometry);
void rtcCommitScene(RTCScene);
void* rtcSetNewGeometryBuffer(RTCGeometry, int type, unsigned slot, int fmt, size_t stride, size_t n);
void rtcSetGeometryBuildQuality(RTCGeometry, RTCBuildQuality);
void rtcSetSceneBuildQuality(RTCScene, RTCBuildQuality);
void rtcSetSceneFlags(RTCScene, int);
unsigned rtcAttachGeometry(RTCScene, RTCGeometry);
void rtcIntersect1(RTCScene, void*, Args*);
void rtcOccluded1(RTCScene, void*, Args*);
#define D(N)                                                  \
    void rtcIntersect##N(const int*, RTCScene, void*, Args*); \
    void rtcOccluded##N(const int*, RTCScene, void*, Args*);
D(4) D(8) D(16)
#undef D
}
