#include <algorithm>

#include <vtkCamera.h>
#include <vtkFrustumCoverageCuller.h>
#include <vtkNew.h>
#include <vtkProp.h>
#include <vtkRenderer.h>
#include <vtkSmartPointer.h>

#include "sightline/study/camera.h"
#include "sightline/study/peer.h"

namespace sightline::study {
namespace {

/// A prop that is nothing but its box; cheaper to ask than a vtkActor, whose bounds are checked for changes.
class Prop : public vtkProp {
 public:
  static Prop* New() { return new Prop; }
  double* GetBounds() override { return bounds; }
  double bounds[6] = {};
  std::uint32_t id = 0;
};

/// Rendering backends replace vtkRenderer; this one is there for its camera.
class Renderer : public vtkRenderer {
 public:
  static Renderer* New() { return new Renderer; }
  void DeviceRender() override {}
};

class Vtk : public Method {
 public:
  explicit Vtk(std::span<const core::Aabb> boxes) {
    renderer_->SetActiveCamera(camera_);
    camera_->UseExplicitAspectRatioOn();
    for (std::uint32_t i = 0; i < boxes.size(); ++i) {
      props_.push_back(vtkSmartPointer<Prop>::New());
      for (int axis = 0; axis < 3; ++axis) {
        props_[i]->bounds[2 * axis] = double(boxes[i].min[axis]);
        props_[i]->bounds[2 * axis + 1] = double(boxes[i].max[axis]);
      }
      props_[i]->id = i;
      all_.push_back(props_[i]);
    }
    list_ = all_;
  }

  /// As vtkRenderer has it: the list of visible props is copied for each frame, then the culler shortens it.
  void cull(const core::View& view) override {
    list_ = all_;
    kept_ = int(list_.size());
    const auto from = symmetric(view);
    if (!from) return;
    const core::dvec3 target = from->eye + from->forward;
    camera_->SetPosition(from->eye.x, from->eye.y, from->eye.z);
    camera_->SetFocalPoint(target.x, target.y, target.z);
    camera_->SetViewUp(from->up.x, from->up.y, from->up.z);
    camera_->SetViewAngle(glm::degrees(from->fovy));
    camera_->SetExplicitAspectRatio(from->aspect);
    camera_->SetClippingRange(from->near, from->far);
    int initialized = 0;
    culler_->Cull(renderer_, list_.data(), kept_, initialized);
  }

  std::uint64_t count() const override { return std::uint64_t(kept_); }
  std::vector<std::uint32_t> ids() const override {
    std::vector<std::uint32_t> ids;
    for (int i = 0; i < kept_; ++i) ids.push_back(static_cast<const Prop*>(list_[std::size_t(i)])->id);
    std::sort(ids.begin(), ids.end());
    return ids;
  }

 private:
  vtkNew<vtkCamera> camera_;
  vtkNew<Renderer> renderer_;
  vtkNew<vtkFrustumCoverageCuller> culler_;
  std::vector<vtkSmartPointer<Prop>> props_;
  std::vector<vtkProp*> all_, list_;
  int kept_ = 0;
};

}  // namespace

std::unique_ptr<Method> make_vtk(std::span<const core::Aabb> boxes) {
  return std::make_unique<Vtk>(boxes);
}

}  // namespace sightline::study
