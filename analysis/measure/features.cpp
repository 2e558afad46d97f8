#include "sightline/analysis/measure/features.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "sightline/analysis/measure/internal/shape.h"

namespace sightline::measure {
namespace {

core::Expected<void> check_finite(const core::Primitive& primitive, const core::Affine& world_from_item) {
  const std::string name(core::name_of(core::kind_of(primitive)));
  for (const float value : core::parameters(primitive))
    if (!std::isfinite(value)) return core::fail("measure: " + name + ": expected finite parameters");
  if (!core::is_finite(world_from_item)) return core::fail("measure: " + name + ": expected a finite placement");
  return {};
}

/// The direction of a sweep angle.
dvec3 radial(double t) {
  return {std::cos(t), std::sin(t), 0.0};
}

class Collector {
 public:
  Collector(core::Kind kind, const core::Affine& placement) : kind_(kind), placement_(placement) {
    const dmat3& m = placement.linear;
    normal_from_local_ = {glm::cross(m[1], m[2]), glm::cross(m[2], m[0]), glm::cross(m[0], m[1])};
    if (glm::dot(m[0], normal_from_local_[0]) < 0.0) normal_from_local_ = -normal_from_local_;  // mirrored
  }
  std::vector<Feature> take() { return std::move(features_); }

  void operator()(const core::Pyramid& p) { polyhedron(corners_of(p)); }
  void operator()(const core::Box& b) { polyhedron(corners_of(as_pyramid(b))); }
  void operator()(const core::RectangularTorus& t) {
    const auto [inner, outer] = std::minmax({length_of(t.inner_radius), length_of(t.outer_radius)});
    const double half = 0.5 * length_of(t.height), sweep = core::sweep_angle(t.angle);
    add(FeatureKind::kCentre, "the bend", point(dvec3(0.0)));
    add(FeatureKind::kAxis, "", swept({0, 0, 0}, 0.5 * (inner + outer), sweep));
    for (const double z : {-half, half}) {
      for (const double radius : {inner, outer}) add(FeatureKind::kEdge, "", swept({0, 0, z}, radius, sweep));
      Face face = disc({{0, 0, z}, {outer, 0, 0}, {0, outer, 0}}, {0, 0, z < 0.0 ? -1 : 1});
      const Arc axes = principal_axes({face.centre, vector({outer, 0, 0}), vector({0, outer, 0}), 0.0, sweep});
      face.inner = outer > 0.0 ? inner / outer : 0.0;
      face.from = axes.from, face.to = axes.to;
      add(FeatureKind::kFace, "", face);
    }
    if (sweep == core::kFullTurn) return;
    for (const double angle : {0.0, sweep}) {
      const dvec3 e = radial(angle), out = (angle == 0.0 ? 1.0 : -1.0) * dvec3(e.y, -e.x, 0.0);
      const dvec3 ring[4] = {inner * e + dvec3(0, 0, -half), outer * e + dvec3(0, 0, -half),
                             outer * e + dvec3(0, 0, half), inner * e + dvec3(0, 0, half)};
      for (int i = 0; i < 4; ++i) corner(ring[i]), edge(ring[i], ring[(i + 1) % 4]);
      polygon({ring[0], ring[1], ring[2], ring[3]}, out);
    }
  }
  void operator()(const core::CircularTorus& t) {
    const double major = length_of(t.major_radius), tube = length_of(t.tube_radius), sweep = core::sweep_angle(t.angle);
    add(FeatureKind::kCentre, "the bend", point(dvec3(0.0)));
    add(FeatureKind::kAxis, "", swept({0, 0, 0}, major, sweep));
    if (sweep == core::kFullTurn) return;
    std::array<SnoutEnd, 2> ends;
    for (int i = 0; i < 2; ++i) {
      const dvec3 e = radial(i == 0 ? 0.0 : sweep);
      ends[i] = {{major * e, tube * e, {0, 0, tube}}, dvec3(-e.y, e.x, 0)};
    }
    round_ends(ends);
  }
  void operator()(const core::EllipticalDish& d) { dish(length_of(d.base_radius), length_of(d.height)); }
  void operator()(const core::SphericalDish& d) { dish(length_of(d.base_radius), length_of(d.height)); }
  void operator()(const core::Snout& s) {
    const dvec3 top(0.5 * s.offset_x, 0.5 * s.offset_y, 0.5 * length_of(s.height));
    add(FeatureKind::kAxis, "", Segment{point(-top), point(top)});
    if (const auto ends = snout_ends(s)) round_ends(*ends);
  }
  void operator()(const core::Cylinder& c) {
    const double r = length_of(c.radius), half = 0.5 * length_of(c.height);
    add(FeatureKind::kAxis, "", Segment{point({0, 0, -half}), point({0, 0, half})});
    round_ends({SnoutEnd{{{0, 0, -half}, {r, 0, 0}, {0, r, 0}}, {0, 0, 1}},
                {{{0, 0, half}, {r, 0, 0}, {0, r, 0}}, {0, 0, 1}}});
  }
  void operator()(const core::Sphere&) { add(FeatureKind::kCentre, "", point(dvec3(0.0))); }
  void operator()(const core::Line& l) {
    for (const double x : {l.from, l.to}) add(FeatureKind::kCorner, "the end", point({x, 0, 0}));
    edge({l.from, 0, 0}, {l.to, 0, 0});
  }

 private:
  dvec3 point(const dvec3& local) const { return core::transform_point(placement_, local); }
  dvec3 vector(const dvec3& local) const { return placement_.linear * local; }
  dvec3 normal(const dvec3& local) const {
    const dvec3 n = normal_from_local_ * local;
    const double size = glm::length(n);
    return size > 0.0 ? n / size : dvec3(0.0);
  }
  void add(FeatureKind kind, std::string_view part, Geometry geometry) {
    features_.push_back({kind, kind_, part, std::move(geometry)});
  }
  Arc swept(const dvec3& centre, double radius, double sweep) const {
    return principal_axes({point(centre), vector({radius, 0, 0}), vector({0, radius, 0}), 0.0, sweep});
  }
  Face disc(const Disc& local, const dvec3& outwards) const {
    const Arc rim = principal_axes({point(local.centre), vector(local.u), vector(local.v)});
    return {rim.centre, normal(outwards), {}, rim.u, rim.v};
  }

  void corner(const dvec3& local) {
    const Geometry at = point(local);
    const auto is_same = [&](const Feature& f) {
      return f.kind == FeatureKind::kCorner && std::get<dvec3>(f.geometry) == std::get<dvec3>(at);
    };
    if (std::none_of(features_.begin(), features_.end(), is_same)) add(FeatureKind::kCorner, "", at);
  }
  void edge(const dvec3& from, const dvec3& to) {
    if (from != to) add(FeatureKind::kEdge, "", Segment{point(from), point(to)});
  }
  void polygon(const std::array<dvec3, 4>& ring, const dvec3& outwards) {
    Face face{point(0.25 * (ring[0] + ring[1] + ring[2] + ring[3])), normal(outwards), {}};
    for (const dvec3& p : ring) face.corners.push_back(point(p));
    add(FeatureKind::kFace, "", std::move(face));
  }
  void polyhedron(const std::array<dvec3, 8>& c) {
    for (const dvec3& p : c) corner(p);
    const auto face = [&](int i, int j, int k, int l) {
      const dvec3 outwards = glm::cross(c[k] - c[i], c[l] - c[j]);
      if (outwards != dvec3(0.0)) polygon({c[i], c[j], c[k], c[l]}, outwards);
    };
    for (int i = 0; i < 4; ++i) {
      const int next = (i + 1) % 4;
      edge(c[i], c[next]), edge(c[i + 4], c[next + 4]), edge(c[i], c[i + 4]);
      face(i, next, next + 4, i + 4);
    }
    face(0, 3, 2, 1), face(4, 5, 6, 7);
  }
  void round_end(const Disc& end, std::string_view part, const dvec3& outwards) {
    const Face face = disc(end, outwards);
    if (face.u == dvec3(0.0) && face.v == dvec3(0.0)) return add(FeatureKind::kCorner, "the tip", face.centre);
    add(FeatureKind::kEdge, part, Arc{face.centre, face.u, face.v});
    add(FeatureKind::kCentre, part, face.centre);
    add(FeatureKind::kFace, part, face);
  }
  void round_ends(const std::array<SnoutEnd, 2>& ends) {
    constexpr double kLevel = 1e-6;
    const dvec3 between = vector(ends[1].contour.centre - ends[0].contour.centre);
    const double rise = std::fabs(between.z) > kLevel * glm::length(between) ? between.z : 0.0;
    for (int i = 0; i < 2; ++i) {
      const bool lower = (rise > 0.0) == (i == 0);
      const std::string_view part = rise == 0.0 ? "an end" : lower ? "the lower end" : "the upper end";
      round_end(ends[i].contour, part, i == 0 ? -ends[i].upwards : ends[i].upwards);
    }
  }
  void dish(double radius, double height) {
    add(FeatureKind::kAxis, "", Segment{point(dvec3(0.0)), point({0, 0, height})});
    round_end({dvec3(0.0), {radius, 0, 0}, {0, radius, 0}}, "the base", {0, 0, -1});
  }

  core::Kind kind_;
  const core::Affine& placement_;
  dmat3 normal_from_local_;
  std::vector<Feature> features_;
};

/// Names of a circle's diameter, and of an ellipse's.
struct DiameterNames {
  std::string_view circle, largest, smallest;
};
constexpr DiameterNames kOuter{"diameter", "largest diameter", "smallest diameter"};
constexpr DiameterNames kTube{"tube diameter", "largest tube diameter", "smallest tube diameter"};
constexpr DiameterNames kBase{"base diameter", "largest base diameter", "smallest base diameter"};
constexpr DiameterNames kBottom{"bottom diameter", "largest bottom diameter", "smallest bottom diameter"};
constexpr DiameterNames kTop{"top diameter", "largest top diameter", "smallest top diameter"};

/// Whether two lengths differ by no more than single-precision placements do.
bool nearly_equal(double a, double b) {
  return std::fabs(a - b) <= 1e-6 * std::max(a, b);
}

class Dimensioner {
 public:
  explicit Dimensioner(const core::Affine& placement) : m_(placement.linear) {}
  std::vector<Dimension> take() { return std::move(dimensions_); }

  void operator()(const core::Pyramid& p) {
    add("bottom x", length_of(p.bottom_x) * glm::length(m_[0]));
    add("bottom y", length_of(p.bottom_y) * glm::length(m_[1]));
    add("top x", length_of(p.top_x) * glm::length(m_[0]));
    add("top y", length_of(p.top_y) * glm::length(m_[1]));
    height(p.height);
  }
  void operator()(const core::Box& b) {
    add("size x", length_of(b.size_x) * glm::length(m_[0]));
    add("size y", length_of(b.size_y) * glm::length(m_[1]));
    add("size z", length_of(b.size_z) * glm::length(m_[2]));
  }
  void operator()(const core::RectangularTorus& t) {
    const auto [inner, outer] = std::minmax({length_of(t.inner_radius), length_of(t.outer_radius)});
    if (is_round()) {
      add("inner radius", inner * glm::length(m_[0]));
      add("outer radius", outer * glm::length(m_[0]));
      add("sweep", core::sweep_angle(t.angle), true);
    }
    height(t.height);
  }
  void operator()(const core::CircularTorus& t) {
    diameters(kTube, length_of(t.tube_radius) * m_[0], length_of(t.tube_radius) * m_[2]);
    if (!is_round()) return;
    add("bend radius", length_of(t.major_radius) * glm::length(m_[0]));
    add("sweep", core::sweep_angle(t.angle), true);
  }
  void operator()(const core::EllipticalDish& d) {
    diameters(kBase, length_of(d.base_radius) * m_[0], length_of(d.base_radius) * m_[1]);
    height(d.height);
  }
  void operator()(const core::SphericalDish& d) {
    diameters(kBase, length_of(d.base_radius) * m_[0], length_of(d.base_radius) * m_[1]);
    height(d.height);
  }
  void operator()(const core::Snout& s) {
    diameters(kBottom, length_of(s.bottom_radius) * m_[0], length_of(s.bottom_radius) * m_[1]);
    diameters(kTop, length_of(s.top_radius) * m_[0], length_of(s.top_radius) * m_[1]);
    add("length", glm::length(m_ * dvec3(s.offset_x, s.offset_y, length_of(s.height))));
  }
  void operator()(const core::Cylinder& c) {
    const double axis = glm::length(m_[2]);
    const dvec3 along = axis > 0.0 ? m_[2] / axis : dvec3(0.0);
    const auto across = [&](const dvec3& v) { return length_of(c.radius) * (v - along * glm::dot(along, v)); };
    diameters(kOuter, across(m_[0]), across(m_[1]));
    add("length", length_of(c.height) * axis);
  }
  void operator()(const core::Sphere& s) {
    const double r = 0.5 * length_of(s.diameter);
    std::array<dvec3, 3> axes{r * m_[0], r * m_[1], r * m_[2]};
    // One-sided Jacobi rotations make the columns perpendicular, the longest first.
    constexpr int kPairs[3][2] = {{0, 1}, {0, 2}, {1, 2}};
    for (int round = 0; round < 16; ++round)
      for (const auto& [i, j] : kPairs) {
        const Arc pair = principal_axes({dvec3(0.0), axes[i], axes[j]});
        axes[i] = pair.u, axes[j] = pair.v;
      }
    diameters(kOuter, axes[0], axes[2]);
  }
  void operator()(const core::Line& l) { add("length", std::fabs(double(l.to) - l.from) * glm::length(m_[0])); }

 private:
  void add(std::string_view name, double value, bool angle = false) { dimensions_.push_back({name, value, angle}); }
  void diameters(const DiameterNames& names, const dvec3& u, const dvec3& v) {
    const Arc axes = principal_axes({dvec3(0.0), u, v});
    const double a = glm::length(axes.u), b = glm::length(axes.v);
    if (nearly_equal(a, b)) return add(names.circle, a + b);
    add(names.largest, 2.0 * a);
    add(names.smallest, 2.0 * b);
  }
  /// Between the planes of both ends.
  void height(float value) {
    const dvec3 n = glm::cross(m_[0], m_[1]);
    const double size = glm::length(n);
    add("height", size > 0.0 ? length_of(value) * std::fabs(glm::dot(m_[2], n)) / size : 0.0);
  }
  bool is_round() const {
    const Arc axes = principal_axes({dvec3(0.0), m_[0], m_[1]});
    return nearly_equal(glm::length(axes.u), glm::length(axes.v));
  }

  const dmat3& m_;
  std::vector<Dimension> dimensions_;
};

}  // namespace

std::string describe(const Feature& feature) {
  constexpr std::string_view kNouns[] = {"corner", "edge", "centre", "axis", "face", "surface"};
  std::string kind(core::name_of(feature.of));
  std::replace(kind.begin(), kind.end(), '_', ' ');
  std::string words(kNouns[std::size_t(feature.kind)]);
  if (feature.kind == FeatureKind::kAxis && std::holds_alternative<Arc>(feature.geometry)) words = "centre line";
  if (feature.kind == FeatureKind::kCorner && !feature.part.empty()) {
    words = feature.part;  // "the tip"
  } else if (!feature.part.empty()) {
    words += " of ";
    words += feature.part;
  }
  return words + (kind[0] == 'e' ? " of an " : " of a ") + kind;
}

core::Expected<std::vector<Feature>> features(const core::Primitive& primitive, const core::Affine& world_from_item) {
  if (auto finite = check_finite(primitive, world_from_item); !finite) return tl::unexpected(finite.error());
  Collector collector(core::kind_of(primitive), world_from_item);
  std::visit(collector, primitive);
  return collector.take();
}

core::Expected<std::vector<Dimension>> dimensions(const core::Primitive& primitive,
                                                  const core::Affine& world_from_item) {
  if (auto finite = check_finite(primitive, world_from_item); !finite) return tl::unexpected(finite.error());
  Dimensioner dimensioner(world_from_item);
  std::visit(dimensioner, primitive);
  return dimensioner.take();
}

Arc principal_axes(const Arc& arc) {
  // Where the distance from the centre is stationary: tan 2 t = 2 u.v / (u.u - v.v).
  const double t = 0.5 * std::atan2(2.0 * glm::dot(arc.u, arc.v), glm::dot(arc.u, arc.u) - glm::dot(arc.v, arc.v));
  const double c = std::cos(t), s = std::sin(t);
  return {arc.centre, c * arc.u + s * arc.v, c * arc.v - s * arc.u, arc.from - t, arc.to - t};
}

}  // namespace sightline::measure
