// SPDX-License-Identifier: Apache-2.0
// Ray-surface intersection by Embree; the only file that includes it.
//
// One RTCScene per group. Geometry ids of a group's scene: its meshes (0 to m-1), all its quadrics
// as the primitives of one user geometry (m), and in the last group its still instances (m+1+i for
// instance i) and all its moving instances as the primitives of one user geometry (after those).
// Moving instances are ours and not Embree's so that a ray is carried into the group by exactly the
// transform with which its hit is carried back: slerp and linear stretch in double.
#include <embree3/rtcore.h>
#include <fmt/format.h>

#include <atomic>
#include <exception>

#include "core/accelerator.h"
#include "core/parallel.h"
#include "core/triangle_mesh.h"

namespace brume {

namespace {

/// More triangles than this are built faster and with less memory, without spatial splits: those
/// take twice as much while the tree is built.
constexpr std::size_t kMostTrianglesForHighQuality = 200'000;
/// Segments of the shutter time for which moving instances have bounds of their own.
constexpr int kMotionSegments = 16;
/// Embree drops what lies beyond.
constexpr float kLargestCoordinate = 1.8e18f;

/// Embree's context of one query, with the time in the scene's units and what a callback would have
/// thrown: exceptions do not pass through Embree.
struct QueryContext : RTCIntersectContext {
  float time = 0;
  std::exception_ptr failure = nullptr;

  void rethrow() const {
    if (failure) [[unlikely]]
      std::rethrow_exception(failure);
  }
};

struct DeviceDeleter {
  void operator()(RTCDeviceTy* device) const { rtcReleaseDevice(device); }
};
struct SceneDeleter {
  void operator()(RTCSceneTy* scene) const { rtcReleaseScene(scene); }
};
struct GeometryDeleter {
  void operator()(RTCGeometryTy* geometry) const { rtcReleaseGeometry(geometry); }
};
using DevicePtr = std::unique_ptr<RTCDeviceTy, DeviceDeleter>;
using ScenePtr = std::unique_ptr<RTCSceneTy, SceneDeleter>;
using GeometryPtr = std::unique_ptr<RTCGeometryTy, GeometryDeleter>;

/// A group's scene, and its primitives by geometry and primitive id.
struct GroupScene {
  ScenePtr scene;
  std::vector<const Primitive*> meshes;
  std::vector<const Primitive*> quadrics;
  Bounds3 bounds;
};

struct MovingInstance {
  const AnimatedTransform* groupToParent = nullptr;
  RTCScene scene = nullptr;
  unsigned id = 0;                  // what a still instance would have as its geometry id
  std::vector<Bounds3> stepBounds;  // kMotionSegments + 1; interpolated they hold the moving group
};

void setBounds(const Bounds3& b, RTCBounds& out) {
  out.lower_x = b.lo.x, out.lower_y = b.lo.y, out.lower_z = b.lo.z;
  out.upper_x = b.hi.x, out.upper_y = b.hi.y, out.upper_z = b.hi.z;
}

void setRay(const Ray& ray, float time, RTCRay& out) {
  out.org_x = ray.o.x, out.org_y = ray.o.y, out.org_z = ray.o.z;
  out.dir_x = ray.d.x, out.dir_y = ray.d.y, out.dir_z = ray.d.z;
  out.tnear = 0;
  out.tfar = ray.tMax;
  out.time = time;
  out.mask = ~0u;
  out.id = 0;
  out.flags = 0;
}

/// Whether Embree takes the ray: Debian's build stops the program at a NaN or at huge coordinates.
bool isUsable(const Ray& ray) {
  const Vec3 o = abs(ray.o), d = abs(ray.d);
  return ray.tMax > 0.f && o.x + o.y + o.z <= kLargestCoordinate &&
         d.x + d.y + d.z <= kLargestCoordinate;
}

Ray rayOf(const RTCRay& r, float time) {
  return {{r.org_x, r.org_y, r.org_z}, {r.dir_x, r.dir_y, r.dir_z}, r.tfar, time};
}

float timeOf(const RTCIntersectContext* context) {
  return static_cast<const QueryContext*>(context)->time;
}

// Callbacks: quadrics (user pointer: the GroupScene).

void quadricBounds(const RTCBoundsFunctionArguments* args) {
  const auto& group = *static_cast<const GroupScene*>(args->geometryUserPtr);
  setBounds(group.quadrics[args->primID]->shape->bounds(), *args->bounds_o);
}

void quadricIntersect(const RTCIntersectFunctionNArguments* args) {
  if (!args->valid[0]) return;
  const auto& group = *static_cast<const GroupScene*>(args->geometryUserPtr);
  auto& rayHit = *reinterpret_cast<RTCRayHit*>(args->rayhit);
  const Shape& shape = *group.quadrics[args->primID]->shape;
  const std::optional<ShapeHit> hit = shape.intersect(rayOf(rayHit.ray, 0));
  if (!hit) return;
  rayHit.ray.tfar = hit->t;
  rayHit.hit.u = hit->u;
  rayHit.hit.v = hit->v;
  rayHit.hit.geomID = args->geomID;
  rayHit.hit.primID = args->primID;
  rayHit.hit.instID[0] = args->context->instID[0];
}

void quadricOccluded(const RTCOccludedFunctionNArguments* args) {
  if (!args->valid[0]) return;
  const auto& group = *static_cast<const GroupScene*>(args->geometryUserPtr);
  auto& ray = *reinterpret_cast<RTCRay*>(args->ray);
  if (group.quadrics[args->primID]->shape->intersect(rayOf(ray, 0))) ray.tfar = -kInfinity;
}

// Callbacks: moving instances (user pointer: the first MovingInstance).

void movingBounds(const RTCBoundsFunctionArguments* args) {
  const auto& moving = static_cast<const MovingInstance*>(args->geometryUserPtr)[args->primID];
  setBounds(moving.stepBounds[args->timeStep], *args->bounds_o);
}

/// The ray in the space of the group, carried there in double.
Ray rayIntoGroup(const Ray& ray, const AnimatedTransform& groupToParent) {
  const Mat4d m = groupToParent.at(ray.time).inverseMatrix();
  return {Vec3(m * glm::dvec4(Vec3d(ray.o), 1)), Vec3(m * glm::dvec4(Vec3d(ray.d), 0)), ray.tMax,
          ray.time};
}

void movingIntersect(const RTCIntersectFunctionNArguments* args) {
  if (!args->valid[0]) return;
  const auto& moving = static_cast<const MovingInstance*>(args->geometryUserPtr)[args->primID];
  auto& rayHit = *reinterpret_cast<RTCRayHit*>(args->rayhit);
  const Ray ray = rayIntoGroup(rayOf(rayHit.ray, timeOf(args->context)), *moving.groupToParent);
  if (!isUsable(ray)) return;
  RTCRayHit inside;
  setRay(ray, 0, inside.ray);
  inside.hit.geomID = RTC_INVALID_GEOMETRY_ID;
  args->context->instID[0] = moving.id;
  rtcIntersect1(moving.scene, args->context, &inside);
  args->context->instID[0] = RTC_INVALID_GEOMETRY_ID;
  if (inside.hit.geomID == RTC_INVALID_GEOMETRY_ID) return;
  rayHit.hit = inside.hit;
  rayHit.hit.instID[0] = moving.id;
  rayHit.ray.tfar = inside.ray.tfar;
}

void movingOccluded(const RTCOccludedFunctionNArguments* args) {
  if (!args->valid[0]) return;
  const auto& moving = static_cast<const MovingInstance*>(args->geometryUserPtr)[args->primID];
  auto& ray = *reinterpret_cast<RTCRay*>(args->ray);
  const Ray local = rayIntoGroup(rayOf(ray, timeOf(args->context)), *moving.groupToParent);
  if (!isUsable(local)) return;
  RTCRay inside;
  setRay(local, 0, inside);
  args->context->instID[0] = moving.id;
  rtcOccluded1(moving.scene, args->context, &inside);
  args->context->instID[0] = RTC_INVALID_GEOMETRY_ID;
  if (inside.tfar < 0) ray.tfar = -kInfinity;
}

/// Filter of meshes with alpha (user pointer: the mesh): a hit where it is cut does not count.
void alphaFilter(const RTCFilterFunctionNArguments* args) {
  const auto& mesh = *static_cast<const TriangleMesh*>(args->geometryUserPtr);
  const auto& hit = *reinterpret_cast<const RTCHit*>(args->hit);
  try {
    if (args->valid[0] == -1 && !mesh.isOpaqueAt(hit.primID, hit.u, hit.v)) args->valid[0] = 0;
  } catch (...) {  // the texture's file cannot be read
    static_cast<QueryContext*>(args->context)->failure = std::current_exception();
  }
}

class EmbreeAccelerator final : public Accelerator {
 public:
  explicit EmbreeAccelerator(const std::vector<PrimitiveGroup>& groups);

  std::optional<SceneHit> intersect(const Ray& ray) const override;
  bool occluded(const Ray& ray) const override;
  Bounds3 bounds() const override { return groupScenes_.back().bounds; }
  std::size_t memoryBytes() const override { return static_cast<std::size_t>(memory_.load()); }
  std::size_t peakMemoryBytes() const override { return static_cast<std::size_t>(peak_.load()); }

 private:
  void buildGroup(const PrimitiveGroup& group, GroupScene& out);
  void attachMesh(const TriangleMesh& mesh, RTCScene scene, unsigned id);
  void attachQuadrics(GroupScene& group, unsigned id);
  void attachInstances(GroupScene& top);
  void addMovingInstance(const PrimitiveGroup::Instance& instance, unsigned id);
  void attachMovingInstances(RTCScene scene, unsigned id);
  void commit(RTCScene scene);
  void throwIfFailed() const;
  void countMemory(std::int64_t bytes) {
    const std::int64_t now = memory_ += bytes;
    if (now > peak_) peak_ = now;  // one thread builds
  }
  /// Position of a time in the span in which anything moves, as Embree wants it.
  float shutterPosition(float time) const {
    return std::clamp((time - motionStart_) * inverseMotionLength_, 0.f, 1.f);
  }

  // Destroyed in reverse order: what the callbacks of the device write to outlives it.
  std::atomic<std::int64_t> memory_{0}, peak_{0};
  std::string error_;
  bool outOfMemory_ = false;
  DevicePtr device_;
  std::vector<GroupScene> groupScenes_;
  std::vector<MovingInstance> moving_;
  const std::vector<PrimitiveGroup::Instance>* instances_ = nullptr;
  RTCScene top_ = nullptr;
  unsigned firstInstanceId_ = 0;
  float motionStart_ = 0, inverseMotionLength_ = 0;
};

EmbreeAccelerator::EmbreeAccelerator(const std::vector<PrimitiveGroup>& groups) {
  BRUME_CHECK(!groups.empty());
  device_.reset(rtcNewDevice(nullptr));
  if (!device_) throw InternalError("Embree cannot be started on this machine");
  rtcSetDeviceMemoryMonitorFunction(
      device_.get(),
      [](void* self, ssize_t bytes, bool) {
        static_cast<EmbreeAccelerator*>(self)->countMemory(bytes);
        return true;
      },
      this);
  rtcSetDeviceErrorFunction(
      device_.get(),
      [](void* self, RTCError code, const char* text) {
        auto& accelerator = *static_cast<EmbreeAccelerator*>(self);
        accelerator.outOfMemory_ |= code == RTC_ERROR_OUT_OF_MEMORY;
        if (accelerator.error_.empty() && text) accelerator.error_ = text;
      },
      this);

  // Built by one thread: Embree's order of triangles, and with it which of two equally near ones is
  // hit, would depend on the number of threads.
  instances_ = &groups.back().instances;
  groupScenes_.resize(groups.size());
  runSerially([&] {
    for (std::size_t i = 0; i < groups.size(); ++i) buildGroup(groups[i], groupScenes_[i]);
  });
  top_ = groupScenes_.back().scene.get();
}

void EmbreeAccelerator::buildGroup(const PrimitiveGroup& group, GroupScene& out) {
  out.scene.reset(rtcNewScene(device_.get()));
  throwIfFailed();
  rtcSetSceneFlags(out.scene.get(), RTC_SCENE_FLAG_ROBUST);

  std::size_t triangles = 0;
  for (const Primitive& primitive : group.primitives) {
    out.bounds.extend(primitive.shape->bounds());
    if (const TriangleMesh* mesh = primitive.shape->mesh()) {
      attachMesh(*mesh, out.scene.get(), static_cast<unsigned>(out.meshes.size()));
      out.meshes.push_back(&primitive);
      triangles += mesh->triangleCount();
    } else {
      out.quadrics.push_back(&primitive);
    }
  }
  if (!out.quadrics.empty()) attachQuadrics(out, static_cast<unsigned>(out.meshes.size()));
  if (&out == &groupScenes_.back()) attachInstances(out);

  const bool small = triangles <= kMostTrianglesForHighQuality;
  rtcSetSceneBuildQuality(out.scene.get(),
                          small ? RTC_BUILD_QUALITY_HIGH : RTC_BUILD_QUALITY_MEDIUM);
  commit(out.scene.get());
}

void EmbreeAccelerator::attachMesh(const TriangleMesh& mesh, RTCScene scene, unsigned id) {
  const GeometryPtr geometry(rtcNewGeometry(device_.get(), RTC_GEOMETRY_TYPE_TRIANGLE));
  throwIfFailed();
  rtcSetSharedGeometryBuffer(geometry.get(), RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3,
                             mesh.indexData(), 0, 3 * sizeof(int), mesh.triangleCount());
  rtcSetSharedGeometryBuffer(geometry.get(), RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3,
                             mesh.pointData(), 0, sizeof(Vec3), mesh.pointCount());
  if (mesh.hasAlpha()) {
    // Embree hands the pointer back as it is; the filter does not write through it.
    rtcSetGeometryUserData(geometry.get(), const_cast<TriangleMesh*>(&mesh));
    rtcSetGeometryIntersectFilterFunction(geometry.get(), alphaFilter);
    rtcSetGeometryOccludedFilterFunction(geometry.get(), alphaFilter);
  }
  rtcCommitGeometry(geometry.get());
  rtcAttachGeometryByID(scene, geometry.get(), id);
  throwIfFailed();
}

void EmbreeAccelerator::attachQuadrics(GroupScene& group, unsigned id) {
  const GeometryPtr geometry(rtcNewGeometry(device_.get(), RTC_GEOMETRY_TYPE_USER));
  throwIfFailed();
  rtcSetGeometryUserPrimitiveCount(geometry.get(), static_cast<unsigned>(group.quadrics.size()));
  rtcSetGeometryUserData(geometry.get(), &group);
  rtcSetGeometryBoundsFunction(geometry.get(), quadricBounds, nullptr);
  rtcSetGeometryIntersectFunction(geometry.get(), quadricIntersect);
  rtcSetGeometryOccludedFunction(geometry.get(), quadricOccluded);
  rtcCommitGeometry(geometry.get());
  rtcAttachGeometryByID(group.scene.get(), geometry.get(), id);
  throwIfFailed();
}

void EmbreeAccelerator::attachInstances(GroupScene& top) {
  firstInstanceId_ = static_cast<unsigned>(top.meshes.size()) + 1;

  // The span of time in which anything moves.
  float start = kInfinity, end = -kInfinity;
  for (const PrimitiveGroup::Instance& instance : *instances_) {
    if (!instance.groupToParent.isAnimated()) continue;
    start = std::min(start, instance.groupToParent.startTime());
    end = std::max(end, instance.groupToParent.endTime());
  }
  if (start < end) {
    motionStart_ = start;
    inverseMotionLength_ = 1 / (end - start);
  }

  for (std::size_t i = 0; i < instances_->size(); ++i) {
    const PrimitiveGroup::Instance& instance = (*instances_)[i];
    BRUME_CHECK(instance.group + 1 < groupScenes_.size());
    const GroupScene& group = groupScenes_[instance.group];
    if (group.bounds.isEmpty()) continue;
    const Bounds3 bounds = instance.groupToParent.motionBounds(group.bounds);
    if (!(maxComponent(max(abs(bounds.lo), abs(bounds.hi))) <= kLargestCoordinate))
      throw SceneError("an object instance reaches beyond a distance of 1.8e18");
    top.bounds.extend(bounds);
    const unsigned id = firstInstanceId_ + static_cast<unsigned>(i);
    if (instance.groupToParent.isAnimated()) {
      addMovingInstance(instance, id);
      continue;
    }
    const GeometryPtr geometry(rtcNewGeometry(device_.get(), RTC_GEOMETRY_TYPE_INSTANCE));
    throwIfFailed();
    rtcSetGeometryInstancedScene(geometry.get(), group.scene.get());
    const Mat4 m(instance.groupToParent.start().matrix());
    rtcSetGeometryTransform(geometry.get(), 0, RTC_FORMAT_FLOAT4X4_COLUMN_MAJOR, &m[0][0]);
    rtcCommitGeometry(geometry.get());
    rtcAttachGeometryByID(top.scene.get(), geometry.get(), id);
    throwIfFailed();
  }
  if (!moving_.empty())
    attachMovingInstances(top.scene.get(),
                          firstInstanceId_ + static_cast<unsigned>(instances_->size()));
}

void EmbreeAccelerator::addMovingInstance(const PrimitiveGroup::Instance& instance, unsigned id) {
  const GroupScene& group = groupScenes_[instance.group];
  MovingInstance moving{&instance.groupToParent, group.scene.get(), id, {}};

  // What the group sweeps in each segment of time: the union of some moments, widened by what an
  // arc between two of them can leave it.
  constexpr int kMoments = 8;
  std::vector<Bounds3> swept(kMotionSegments);
  const float length = 1 / (inverseMotionLength_ * kMotionSegments * kMoments);
  for (int segment = 0; segment < kMotionSegments; ++segment) {
    Bounds3 before;
    float largestStep = 0;
    for (int i = 0; i <= kMoments; ++i) {
      const float time = motionStart_ + length * static_cast<float>(segment * kMoments + i);
      const Bounds3 now = instance.groupToParent.at(time).bounds(group.bounds);
      swept[segment].extend(now);
      if (i > 0)
        largestStep = std::max({largestStep, maxComponent(abs(now.lo - before.lo)),
                                maxComponent(abs(now.hi - before.hi))});
      before = now;
    }
    swept[segment].lo -= Vec3(0.25f * largestStep);
    swept[segment].hi += Vec3(0.25f * largestStep);
  }

  // Embree interpolates between steps: a step that holds both neighbouring segments is safe.
  for (int step = 0; step <= kMotionSegments; ++step) {
    Bounds3 b = swept[std::max(0, step - 1)];
    b.extend(swept[std::min(kMotionSegments - 1, step)]);
    moving.stepBounds.push_back(b);
  }
  moving_.push_back(std::move(moving));
}

void EmbreeAccelerator::attachMovingInstances(RTCScene scene, unsigned id) {
  const GeometryPtr geometry(rtcNewGeometry(device_.get(), RTC_GEOMETRY_TYPE_USER));
  throwIfFailed();
  rtcSetGeometryUserPrimitiveCount(geometry.get(), static_cast<unsigned>(moving_.size()));
  rtcSetGeometryTimeStepCount(geometry.get(), kMotionSegments + 1);
  rtcSetGeometryUserData(geometry.get(), moving_.data());
  rtcSetGeometryBoundsFunction(geometry.get(), movingBounds, nullptr);
  rtcSetGeometryIntersectFunction(geometry.get(), movingIntersect);
  rtcSetGeometryOccludedFunction(geometry.get(), movingOccluded);
  rtcCommitGeometry(geometry.get());
  rtcAttachGeometryByID(scene, geometry.get(), id);
  throwIfFailed();
}

void EmbreeAccelerator::commit(RTCScene scene) {
  rtcJoinCommitScene(scene);
  throwIfFailed();
}

void EmbreeAccelerator::throwIfFailed() const {
  if (outOfMemory_) throw std::bad_alloc();
  if (!error_.empty()) throw InternalError("Embree: " + error_);
}

std::optional<SceneHit> EmbreeAccelerator::intersect(const Ray& ray) const {
  if (!isUsable(ray)) return std::nullopt;
  QueryContext context;
  rtcInitIntersectContext(&context);
  context.time = ray.time;
  RTCRayHit rayHit;
  setRay(ray, shutterPosition(ray.time), rayHit.ray);
  rayHit.hit.geomID = RTC_INVALID_GEOMETRY_ID;
  rayHit.hit.instID[0] = RTC_INVALID_GEOMETRY_ID;
  rtcIntersect1(top_, &context, &rayHit);
  context.rethrow();
  const RTCHit& found = rayHit.hit;
  if (found.geomID == RTC_INVALID_GEOMETRY_ID) return std::nullopt;

  SceneHit hit;
  const GroupScene* group = &groupScenes_.back();
  if (found.instID[0] != RTC_INVALID_GEOMETRY_ID) {
    hit.instance = &(*instances_)[found.instID[0] - firstInstanceId_];
    group = &groupScenes_[hit.instance->group];
  }
  hit.shape.t = rayHit.ray.tfar;
  hit.shape.u = std::clamp(found.u, 0.f, 1.f);
  hit.shape.v = std::clamp(found.v, 0.f, 1.f - hit.shape.u);
  if (found.geomID < group->meshes.size()) {
    hit.primitive = group->meshes[found.geomID];
    hit.shape.primitive = found.primID;
  } else {
    hit.primitive = group->quadrics[found.primID];
  }
  return hit;
}

bool EmbreeAccelerator::occluded(const Ray& ray) const {
  if (!isUsable(ray)) return false;
  QueryContext context;
  rtcInitIntersectContext(&context);
  context.time = ray.time;
  RTCRay query;
  setRay(ray, shutterPosition(ray.time), query);
  rtcOccluded1(top_, &context, &query);
  context.rethrow();
  return query.tfar < 0;
}

}  // namespace

std::unique_ptr<Accelerator> buildEmbreeAccelerator(const std::vector<PrimitiveGroup>& groups) {
  return std::make_unique<EmbreeAccelerator>(groups);
}

}  // namespace brume
