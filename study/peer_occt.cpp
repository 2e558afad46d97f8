#include <Aspect_DisplayConnection.hxx>
#include <Aspect_Window.hxx>
#include <Graphic3d_CStructure.hxx>
#include <Graphic3d_CView.hxx>
#include <Graphic3d_Camera.hxx>
#include <Graphic3d_CullingTool.hxx>
#include <Graphic3d_GraphicDriver.hxx>
#include <Graphic3d_Layer.hxx>
#include <Graphic3d_StructureManager.hxx>

#include "sightline/study/camera.h"
#include "sightline/study/peer.h"

namespace sightline::study {
namespace {

/// What structures need to exist: a driver that drives nothing.
class Driver : public Graphic3d_GraphicDriver {
 public:
  Driver() : Graphic3d_GraphicDriver(Handle(Aspect_DisplayConnection)()) {}
  Standard_Integer InquireLimit(const Graphic3d_TypeOfLimit) const override { return 0; }
  Handle(Graphic3d_CStructure) CreateStructure(const Handle(Graphic3d_StructureManager) &) override { return {}; }
  void RemoveStructure(Handle(Graphic3d_CStructure) &) override {}
  Handle(Graphic3d_CView) CreateView(const Handle(Graphic3d_StructureManager) &) override { return {}; }
  void RemoveView(const Handle(Graphic3d_CView) &) override {}
  void EnableVBO(const Standard_Boolean) override {}
  bool IsVerticalSync() const override { return false; }
  void SetVerticalSync(bool) override {}
  Standard_Boolean MemoryInfo(Standard_Size&, TCollection_AsciiString&) const override { return Standard_False; }
  Standard_ShortReal DefaultTextHeight() const override { return 0.0f; }
  void TextSize(const Handle(Graphic3d_CView) &, const Standard_CString, const Standard_ShortReal, Standard_ShortReal&,
                Standard_ShortReal&, Standard_ShortReal&) const override {}
  void InsertLayerBefore(const Graphic3d_ZLayerId, const Graphic3d_ZLayerSettings&, const Graphic3d_ZLayerId) override {
  }
  void InsertLayerAfter(const Graphic3d_ZLayerId, const Graphic3d_ZLayerSettings&, const Graphic3d_ZLayerId) override {}
  void RemoveZLayer(const Graphic3d_ZLayerId) override {}
  void SetZLayerSettings(const Graphic3d_ZLayerId, const Graphic3d_ZLayerSettings&) override {}
  Standard_Boolean ViewExists(const Handle(Aspect_Window) &, Handle(Graphic3d_CView) &) override {
    return Standard_False;
  }
};

class Structure : public Graphic3d_CStructure {
 public:
  Structure(const Handle(Graphic3d_StructureManager) & manager, const core::Aabb& box) : Graphic3d_CStructure(manager) {
    myBndBox = Graphic3d_BndBox3d(Graphic3d_Vec3d(double(box.min.x), double(box.min.y), double(box.min.z)),
                                  Graphic3d_Vec3d(double(box.max.x), double(box.max.y), double(box.max.z)));
  }
  void OnVisibilityChanged() override {}
  void Clear() override {}
  void Connect(Graphic3d_CStructure&) override {}
  void Disconnect(Graphic3d_CStructure&) override {}
  void GraphicHighlight(const Handle(Graphic3d_PresentationAttributes) &) override {}
  void GraphicUnhighlight() override {}
  Handle(Graphic3d_CStructure) ShadowLink(const Handle(Graphic3d_StructureManager) &) const override { return {}; }
  Handle(Graphic3d_Group) NewGroup(const Handle(Graphic3d_Structure) &) override { return {}; }
  void RemoveGroup(const Handle(Graphic3d_Group) &) override {}
};

class Occt : public Method {
 public:
  explicit Occt(std::span<const core::Aabb> boxes)
      : manager_(new Graphic3d_StructureManager(new Driver)),
        layer_(new Graphic3d_Layer(Graphic3d_ZLayerId_Default, 11, Handle(Select3D_BVHBuilder3d)())),
        camera_(new Graphic3d_Camera) {
    structures_.reserve(boxes.size());
    for (const core::Aabb& box : boxes) {
      structures_.push_back(new Structure(manager_, box));
      layer_->Add(structures_.back().get(), 5);  // any of the eleven priorities
    }
    tool_.SetViewportSize(1024, 768, 1.0);
    update(true);  // builds the hierarchy
  }

  void cull(const core::View& view) override {
    const auto from = symmetric(view);
    if (from) {
      camera_->SetProjectionType(Graphic3d_Camera::Projection_Perspective);
      camera_->SetEyeAndCenter(point(from->eye), point(from->eye + from->forward));
      camera_->SetUp(gp_Dir(from->up.x, from->up.y, from->up.z));
      camera_->SetFOVy(glm::degrees(from->fovy));
      camera_->SetAspect(from->aspect);
      camera_->SetZRange(from->near, from->far);
    }
    update(from.has_value());
  }

  std::uint64_t count() const override { return std::uint64_t(layer_->NbStructuresNotCulled()); }
  std::vector<std::uint32_t> ids() const override {
    std::vector<std::uint32_t> ids;
    for (std::uint32_t i = 0; i < structures_.size(); ++i)
      if (!structures_[i]->IsCulled()) ids.push_back(i);
    return ids;
  }

 private:
  static gp_Pnt point(const core::dvec3& p) { return {p.x, p.y, p.z}; }
  void update(bool cull) {
    tool_.SetViewVolume(camera_);
    tool_.CacheClipPtsProjections();
    layer_->UpdateCulling(
        0, tool_, cull ? Graphic3d_RenderingParams::FrustumCulling_On : Graphic3d_RenderingParams::FrustumCulling_Off);
  }

  Handle(Graphic3d_StructureManager) manager_;
  Handle(Graphic3d_Layer) layer_;
  Handle(Graphic3d_Camera) camera_;
  Graphic3d_CullingTool tool_;
  std::vector<Handle(Structure)> structures_;
};

}  // namespace

std::unique_ptr<Method> make_occt(std::span<const core::Aabb> boxes) {
  return std::make_unique<Occt>(boxes);
}

}  // namespace sightline::study
