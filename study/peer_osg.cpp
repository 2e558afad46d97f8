#include <algorithm>

#include <osg/Drawable>
#include <osg/FrameStamp>
#include <osg/Group>
#include <osg/Viewport>
#include <osgUtil/CullVisitor>
#include <osgUtil/RenderStage>
#include <osgUtil/StateGraph>

#include "sightline/study/camera.h"
#include "sightline/study/peer.h"
#include "sightline/study/tree.h"

namespace sightline::study {
namespace {

/// Subtrees of at most so many drawables are one group. Not tuned.
constexpr std::uint32_t kGroupSize = 8;

class Item : public osg::Drawable {
 public:
  Item(const core::Aabb& box, std::uint32_t place)
      : id(place), box_(box.min.x, box.min.y, box.min.z, box.max.x, box.max.y, box.max.z) {}
  osg::BoundingBox computeBoundingBox() const override { return box_; }
  const std::uint32_t id;

 private:
  osg::BoundingBox box_;
};

/// A group for each node of the binary tree of the surface-area heuristic that holds more than kGroupSize items.
osg::ref_ptr<osg::Group> make_scene(std::span<const core::Aabb> boxes) {
  const Tree tree = build_tree(boxes, {}, Split::kSah, kGroupSize);
  osg::ref_ptr<osg::Group> root = new osg::Group;
  struct Open {
    std::uint32_t end;  // first node that is not below it
    osg::Group* group;
  };
  std::vector<Open> open{{std::uint32_t(tree.nodes.size()), root.get()}};
  for (std::uint32_t i = 0; i < tree.nodes.size();) {
    while (open.back().end <= i) open.pop_back();
    const TreeNode& node = tree.nodes[i];
    osg::ref_ptr<osg::Group> group = new osg::Group;
    open.back().group->addChild(group);
    if (node.end - node.first > kGroupSize && !tree.leaf(i)) {
      open.push_back({node.escape, group.get()});
      ++i;
      continue;
    }
    for (std::uint32_t k = node.first; k < node.end; ++k)
      group->addChild(new Item(boxes[tree.order[k]], tree.order[k]));
    i = node.escape;
  }
  return root;
}

class Osg : public Method {
 public:
  explicit Osg(std::span<const core::Aabb> boxes)
      : scene_(make_scene(boxes)),
        visitor_(new osgUtil::CullVisitor),
        graph_(new osgUtil::StateGraph),
        stage_(new osgUtil::RenderStage),
        viewport_(new osg::Viewport(0, 0, 1024, 768)) {
    visitor_->setCullingMode(osg::CullSettings::VIEW_FRUSTUM_CULLING);
    visitor_->setComputeNearFarMode(osg::CullSettings::DO_NOT_COMPUTE_NEAR_FAR);
    visitor_->setFrameStamp(new osg::FrameStamp);
    scene_->getBound();  // computes all bounds below
  }

  /// As osgUtil::SceneView has it.
  void cull(const core::View& view) override {
    const auto camera = symmetric(view);
    visitor_->reset();
    graph_->clean();
    stage_->reset();
    visitor_->setStateGraph(graph_.get());
    visitor_->setRenderStage(stage_.get());
    visitor_->setCullingMode(camera ? osg::CullSettings::VIEW_FRUSTUM_CULLING : osg::CullSettings::NO_CULLING);
    osg::Matrixd projection, from_world;
    if (camera) {
      const auto vector = [](const core::dvec3& v) { return osg::Vec3d(v.x, v.y, v.z); };
      projection.makePerspective(glm::degrees(camera->fovy), camera->aspect, camera->near, camera->far);
      from_world.makeLookAt(vector(camera->eye), vector(camera->eye + camera->forward), vector(camera->up));
    }
    visitor_->pushViewport(viewport_.get());
    visitor_->pushProjectionMatrix(new osg::RefMatrix(projection));
    visitor_->pushModelViewMatrix(new osg::RefMatrix(from_world), osg::Transform::ABSOLUTE_RF);
    scene_->accept(*visitor_);
    visitor_->popModelViewMatrix();
    visitor_->popProjectionMatrix();
    visitor_->popViewport();
  }

  std::uint64_t count() const override { return graph_->_leaves.size(); }
  std::vector<std::uint32_t> ids() const override {
    std::vector<std::uint32_t> ids;
    for (const auto& leaf : graph_->_leaves) ids.push_back(static_cast<const Item*>(leaf->getDrawable())->id);
    std::sort(ids.begin(), ids.end());
    return ids;
  }

 private:
  osg::ref_ptr<osg::Group> scene_;
  osg::ref_ptr<osgUtil::CullVisitor> visitor_;
  osg::ref_ptr<osgUtil::StateGraph> graph_;
  osg::ref_ptr<osgUtil::RenderStage> stage_;
  osg::ref_ptr<osg::Viewport> viewport_;
};

}  // namespace

std::unique_ptr<Method> make_osg(std::span<const core::Aabb> boxes) {
  return std::make_unique<Osg>(boxes);
}

}  // namespace sightline::study
