#include "sightline/bench/embree_peer.h"

#include <algorithm>
#include <atomic>
#include <limits>
#include <string>

#include <embree3/rtcore.h>

#include "sightline/bench/harness.h"

namespace sightline::bench {

struct EmbreePeer::State {
  RTCDevice device = nullptr;
  RTCScene scene = nullptr;
  std::atomic<std::int64_t> bytes = 0;
};

EmbreePeer::EmbreePeer(const core::Mesh& mesh, bool robust, int threads) : state_(std::make_unique<State>()) {
  state_->device = rtcNewDevice(("threads=" + std::to_string(threads)).c_str());
  rtcSetDeviceMemoryMonitorFunction(
      state_->device,
      [](void* state, ssize_t bytes, bool) {
        static_cast<State*>(state)->bytes += bytes;
        return true;
      },
      state_.get());
  state_->scene = rtcNewScene(state_->device);
  rtcSetSceneBuildQuality(state_->scene, RTC_BUILD_QUALITY_MEDIUM);
  rtcSetSceneFlags(state_->scene, robust ? RTC_SCENE_FLAG_ROBUST : RTC_SCENE_FLAG_NONE);
  RTCGeometry geometry = rtcNewGeometry(state_->device, RTC_GEOMETRY_TYPE_TRIANGLE);
  void* vertices = rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, sizeof(core::vec3),
                                           mesh.positions.size());
  void* indices = rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3,
                                          3 * sizeof(std::uint32_t), mesh.indices.size() / 3);
  std::copy(mesh.positions.begin(), mesh.positions.end(), static_cast<core::vec3*>(vertices));
  std::copy(mesh.indices.begin(), mesh.indices.end(), static_cast<std::uint32_t*>(indices));
  rtcCommitGeometry(geometry);
  rtcAttachGeometry(state_->scene, geometry);
  rtcReleaseGeometry(geometry);
  const double begin = milliseconds();
  rtcCommitScene(state_->scene);
  build_ms_ = milliseconds() - begin;
}

EmbreePeer::~EmbreePeer() {
  rtcReleaseScene(state_->scene);
  rtcReleaseDevice(state_->device);
}

std::int64_t EmbreePeer::bytes() const {
  return state_->bytes;
}

std::size_t EmbreePeer::single(std::span<const FloatRay> rays, std::span<float> t) const {
  std::size_t hits = 0;
  for (std::size_t i = 0; i < rays.size(); ++i) {
    const FloatRay& r = rays[i];
    RTCIntersectContext context;
    rtcInitIntersectContext(&context);
    RTCRayHit hit{};
    hit.ray = {r.origin.x, r.origin.y, r.origin.z, r.t_min, r.direction.x, r.direction.y, r.direction.z, 0.0f,
               r.t_max,    ~0u,        0,          0};
    hit.hit.geomID = RTC_INVALID_GEOMETRY_ID;
    rtcIntersect1(state_->scene, &context, &hit);
    const bool met = hit.hit.geomID != RTC_INVALID_GEOMETRY_ID;
    hits += met;
    t[i] = met ? hit.ray.tfar : std::numeric_limits<float>::infinity();
  }
  return hits;
}

std::size_t EmbreePeer::packets(std::span<const FloatRay> rays, std::span<float> t) const {
  constexpr std::size_t kSize = 16;
  std::size_t hits = 0;
  for (std::size_t first = 0; first < rays.size(); first += kSize) {
    const std::size_t count = std::min(kSize, rays.size() - first);
    RTCIntersectContext context;
    rtcInitIntersectContext(&context);
    context.flags = RTC_INTERSECT_CONTEXT_FLAG_COHERENT;
    alignas(64) int valid[kSize];
    RTCRayHit16 hit;
    for (std::size_t i = 0; i < kSize; ++i) {
      const FloatRay& r = rays[first + std::min(i, count - 1)];
      valid[i] = i < count ? -1 : 0;
      hit.ray.org_x[i] = r.origin.x, hit.ray.org_y[i] = r.origin.y, hit.ray.org_z[i] = r.origin.z;
      hit.ray.dir_x[i] = r.direction.x, hit.ray.dir_y[i] = r.direction.y, hit.ray.dir_z[i] = r.direction.z;
      hit.ray.tnear[i] = r.t_min, hit.ray.tfar[i] = r.t_max, hit.ray.time[i] = 0.0f;
      hit.ray.mask[i] = ~0u, hit.ray.id[i] = hit.ray.flags[i] = 0;
      hit.hit.geomID[i] = hit.hit.instID[0][i] = RTC_INVALID_GEOMETRY_ID;
    }
    rtcIntersect16(valid, state_->scene, &context, &hit);
    for (std::size_t i = 0; i < count; ++i) {
      const bool met = hit.hit.geomID[i] != RTC_INVALID_GEOMETRY_ID;
      hits += met;
      t[first + i] = met ? hit.ray.tfar[i] : std::numeric_limits<float>::infinity();
    }
  }
  return hits;
}

}  // namespace sightline::bench
