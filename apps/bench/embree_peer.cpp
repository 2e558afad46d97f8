#include "sightline/apps/bench/embree_peer.h"

#include <algorithm>
#include <atomic>
#include <limits>
#include <string>

#include <embree3/rtcore.h>

#include "sightline/apps/bench/harness.h"
#include "sightline/core/internal/instruction_set.h"
#include "sightline/gpuprims/internal/primitives.h"

namespace sightline::bench {

struct EmbreePeer::State {
  RTCDevice device = nullptr;
  RTCScene scene = nullptr;
  std::atomic<std::int64_t> bytes = 0;
  std::vector<PeerSolid> solids;
};

namespace {

void bound_solid(const RTCBoundsFunctionArguments* arguments) {
  const PeerSolid& s = static_cast<const PeerSolid*>(arguments->geometryUserPtr)[arguments->primID];
  const core::vec3 low(s.box.min), high(s.box.max);
  // A float's rounding, outwards.
  const float margin = 1e-6f * (glm::length(low) + glm::length(high));
  *arguments->bounds_o = {low.x - margin,  low.y - margin,  low.z - margin,  0.0f,
                          high.x + margin, high.y + margin, high.z + margin, 0.0f};
}

void intersect_solid(const RTCIntersectFunctionNArguments* arguments) {
  const PeerSolid& s = static_cast<const PeerSolid*>(arguments->geometryUserPtr)[arguments->primID];
  const unsigned n = arguments->N;
  RTCRayN* const ray = RTCRayHitN_RayN(arguments->rayhit, n);
  RTCHitN* const hit = RTCRayHitN_HitN(arguments->rayhit, n);
  for (unsigned i = 0; i < n; ++i) {
    if (arguments->valid[i] == 0) continue;
    const core::dvec3 origin(RTCRayN_org_x(ray, n, i), RTCRayN_org_y(ray, n, i), RTCRayN_org_z(ray, n, i));
    const core::dvec3 direction(RTCRayN_dir_x(ray, n, i), RTCRayN_dir_y(ray, n, i), RTCRayN_dir_z(ray, n, i));
    const gpuprims::Hits hits =
        gpuprims::intersect(s.solid, core::Ray{s.item_from_world * (origin - s.origin), s.item_from_world * direction});
    for (int k = 0; k < hits.count; ++k) {
      const auto t = float(hits.hit[k].t);
      if (t < RTCRayN_tnear(ray, n, i)) continue;
      if (t > RTCRayN_tfar(ray, n, i)) break;
      RTCRayN_tfar(ray, n, i) = t;
      RTCHitN_Ng_x(hit, n, i) = float(hits.hit[k].normal.x);
      RTCHitN_Ng_y(hit, n, i) = float(hits.hit[k].normal.y);
      RTCHitN_Ng_z(hit, n, i) = float(hits.hit[k].normal.z);
      RTCHitN_primID(hit, n, i) = arguments->primID;
      RTCHitN_geomID(hit, n, i) = arguments->geomID;
      RTCHitN_instID(hit, n, i, 0) = RTC_INVALID_GEOMETRY_ID;
      break;
    }
  }
}

}  // namespace

EmbreePeer::EmbreePeer(const core::Mesh& mesh, std::vector<PeerSolid> solids, bool robust, int threads)
    : state_(std::make_unique<State>()) {
  state_->solids = std::move(solids);
  // Both sides get the same instructions.
  const bool avx2 = core::instruction_set() == core::InstructionSet::kAvx2;
  state_->device = rtcNewDevice(("threads=" + std::to_string(threads) + (avx2 ? ",isa=avx2" : "")).c_str());
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
  if (!state_->solids.empty()) {
    RTCGeometry user = rtcNewGeometry(state_->device, RTC_GEOMETRY_TYPE_USER);
    rtcSetGeometryUserPrimitiveCount(user, unsigned(state_->solids.size()));
    rtcSetGeometryUserData(user, state_->solids.data());
    rtcSetGeometryBoundsFunction(user, bound_solid, nullptr);
    rtcSetGeometryIntersectFunction(user, intersect_solid);
    rtcCommitGeometry(user);
    rtcAttachGeometry(state_->scene, user);
    rtcReleaseGeometry(user);
  }
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
