#include "sightline/culling/occlusion/internal/inner_occluders.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>

namespace sightline::culling {
namespace {

using core::Affine;
using core::dmat3;
using core::dvec3;
using core::Kind;

constexpr double kMostStep = 0.6, kLeastStep = 0.1;  // radians of a torus for one occluder polygon
constexpr double kSagitta = 0.1;                     // of a tube's radius, by which an occluder polygon may be smaller

/// An upper bound of what a map makes of a vector of length 1.
double longest(const dmat3& map) {
  double of_columns = 0.0, of_rows = 0.0;
  for (int i = 0; i < 3; ++i) {
    of_columns = std::max(of_columns, std::abs(map[i][0]) + std::abs(map[i][1]) + std::abs(map[i][2]));
    of_rows = std::max(of_rows, std::abs(map[0][i]) + std::abs(map[1][i]) + std::abs(map[2][i]));
  }
  return std::sqrt(of_columns * of_rows);
}

double length(double x, double y) {
  return std::sqrt(x * x + y * y);
}

/// The occluder polygons of one item, in its own coordinates.
class InnerOccluders {
 public:
  InnerOccluders(Kind kind, const std::array<double, 9>& parameters, const Affine& eye_from_item, const dmat3& inverse,
                 const EyeProjection& projection, double of_radius, double metres, std::vector<OccluderPolygon>& out)
      : kind_(kind),
        parameters_(parameters),
        eye_from_item_(eye_from_item),
        perspective_(projection.perspective),
        eye_(inverse * (projection.perspective ? -eye_from_item.origin : projection.forward)),
        of_radius_(of_radius),
        lost_(metres * longest(inverse)),
        out_(out) {}

  void add() {
    const std::array<double, 9>& p = parameters_;
    const double a = std::abs(p[0]), b = std::abs(p[1]), c = std::abs(p[2]);  // lengths, if it has so many
    switch (kind_) {
      case Kind::kPyramid:
        return pyramid(p);
      case Kind::kBox:
        return box(0.5 * a, 0.5 * b, 0.5 * c);
      case Kind::kRectangularTorus:
        return rectangular_torus(std::min(a, b), std::max(a, b), c, core::sweep_angle(float(p[3])));
      case Kind::kCircularTorus:
        return circular_torus(a, b, core::sweep_angle(float(p[2])));
      case Kind::kEllipticalDish:
        return dish(a, 0.8 * a, b, kEllipse * lost_);
      case Kind::kSphericalDish:
        return spherical_dish(a, b);
      case Kind::kSnout:
        return snout(p);
      case Kind::kCylinder:
        return cone({0.0, 0.0, -0.5 * b}, {0.0, 0.0, 0.5 * b}, a, a);
      case Kind::kSphere:
        return sphere(0.5 * a);
      default:
        return;
    }
  }

  /// Whether all of the item lies behind what it has added.
  bool add_fronts() {
    const std::array<double, 9>& p = parameters_;
    const double a = std::abs(p[0]), b = std::abs(p[1]);
    switch (kind_) {
      case Kind::kCircularTorus:
        return fronts_of_torus(a, b, core::sweep_angle(float(p[2])));
      case Kind::kSnout:
        return front_of_snout(p);
      case Kind::kCylinder:
        return front({0.0, 0.0, -0.5 * b}, {0.0, 0.0, 0.5 * b}, a, 0.0);
      default:
        return false;
    }
  }

 private:
  /// A length within the solid, less what is lost.
  double within(double of) const { return of - of_radius_ * of - lost_; }
  /// The direction in which a point is seen.
  dvec3 seen(const dvec3& point) const { return perspective_ ? point - eye_ : eye_; }

  OccluderPolygon& append(int count, bool hexahedron = false) {
    out_.emplace_back();
    out_.back().count = count;
    out_.back().hexahedron = hexahedron;
    return out_.back();
  }
  dvec3 from_eye(const dvec3& p) const { return core::transform_point(eye_from_item_, p); }

  void quad(const dvec3& a, const dvec3& b, const dvec3& c, const dvec3& d) {
    append(4).corners = {from_eye(a), from_eye(b), from_eye(c), from_eye(d)};
  }
  /// The octagon in the circle centre + u cos t + v sin t.
  void disc(const dvec3& centre, const dvec3& u, const dvec3& v) {
    constexpr double kHalf = 0.5 * std::numbers::sqrt2 * (1.0 - 0x1p-40);
    const dvec3 c = from_eye(centre), x = eye_from_item_.linear * u, y = eye_from_item_.linear * v;
    const dvec3 s = kHalf * (x + y), t = kHalf * (y - x);
    append(8).corners = {c + x, c + s, c + y, c + t, c - x, c - s, c - y, c - t};
  }
  /// `ends`: half sizes and middles along x and y, below and above.
  struct End {
    double x, y, at_x, at_y, z;
  };
  void hexahedron(const End& below, const End& above, double growth) {
    const bool mirrored = glm::determinant(eye_from_item_.linear) < 0.0;
    OccluderPolygon& polygon = append(8, true);
    polygon.growth = growth;
    for (int i = 0; i < 8; ++i) {
      const End& end = (i < 4) != mirrored ? below : above;
      const double x = i % 4 == 0 || i % 4 == 3 ? -end.x : end.x, y = i % 4 < 2 ? -end.y : end.y;
      polygon.corners[std::size_t(i)] = from_eye({end.at_x + x, end.at_y + y, end.z});
    }
  }

  void box(double size_x, double size_y, double size_z) {
    const double x = within(size_x), y = within(size_y), z = within(size_z);
    if (!(x > 0.0 && y > 0.0 && z > 0.0)) return;
    const double growth = std::max({size_x / x, size_y / y, size_z / z});
    hexahedron({x, y, 0.0, 0.0, -z}, {x, y, 0.0, 0.0, z}, 1.0 + kGrowthMargin * (growth - 1.0));
  }
  static constexpr double kGrowthMargin = 2.0;  // float rays see a solid a little larger

  void pyramid(const std::array<double, 9>& p) {
    const double bottom_x = 0.5 * std::abs(p[0]), bottom_y = 0.5 * std::abs(p[1]), top_x = 0.5 * std::abs(p[2]),
                 top_y = 0.5 * std::abs(p[3]), half = 0.5 * std::abs(p[6]), z = within(half);
    if (!(z > 0.0)) return;
    // Sides lean; what is lost from them is more of a level length.
    const double lean =
        std::max(std::abs(bottom_x - top_x) + std::abs(p[4]), std::abs(bottom_y - top_y) + std::abs(p[5]));
    const double lost = of_radius_ * std::max({bottom_x, bottom_y, top_x, top_y}) + lost_ * (1.0 + 0.5 * lean / half);
    const auto end_at = [&](double height) {
      const double s = 0.5 + 0.5 * height / half;
      return End{std::lerp(bottom_x, top_x, s) - lost, std::lerp(bottom_y, top_y, s) - lost, (s - 0.5) * p[4],
                 (s - 0.5) * p[5], height};
    };
    const End below = end_at(-z), above = end_at(z);
    if (std::min({below.x, below.y, above.x, above.y}) > 0.0) hexahedron(below, above, 0.0);
  }

  /// Discs of radii ra and rb, a below b, and what lies between them.
  void cone(dvec3 a, dvec3 b, double ra, double rb) {
    const dvec3 along = b - a;
    if (!(along.z > 0.0)) return;
    const double lean = length(along.x, along.y) + std::abs(ra - rb);
    const double lost = of_radius_ * std::max(ra, rb) + lost_ * (1.0 + lean / along.z);
    const double share = of_radius_ + lost_ / along.z;
    a += share * along, b -= share * along;
    const double slope = share * (rb - ra);
    ra += slope - lost, rb -= slope + lost;
    if (!(share < 0.5 && ra > 0.0 && rb > 0.0)) return;
    const dvec3 v = seen(0.5 * (a + b));
    const double across = length(v.x, v.y);
    if (across > 0.0) {
      const dvec3 w(-v.y / across, v.x / across, 0.0);
      quad(a - ra * w, b - rb * w, b + rb * w, a + ra * w);
    }
    // Both ends and the section cover the outline. Ends that are seen edge-on add little.
    constexpr double kLeastOfEnd = 1.0 / 3.0;
    if (!(std::abs(v.z) * std::max(ra, rb) > kLeastOfEnd * across * (b.z - a.z))) return;
    disc(a, {ra, 0.0, 0.0}, {0.0, ra, 0.0});
    disc(b, {rb, 0.0, 0.0}, {0.0, rb, 0.0});
  }

  /// Slanted ends are cut off where they begin.
  void snout(const std::array<double, 9>& p) {
    const double ra = std::abs(p[0]), rb = std::abs(p[1]), height = std::abs(p[2]), widest = std::max(ra, rb);
    // Places count from the middle of the end, and the axis may lean.
    const auto reach = [&](double x, double y) {
      if (x == 0.0 && y == 0.0) return 0.0;
      const double slope_x = std::tan(x), slope_y = std::tan(y);
      return widest * length(slope_x, slope_y) + std::abs(slope_x * p[3]) + std::abs(slope_y * p[4]);
    };
    const double low = reach(p[5], p[6]) / height, high = 1.0 - reach(p[7], p[8]) / height;
    if (!(height > 0.0 && low < high)) return;
    const auto at = [&](double s) { return dvec3((s - 0.5) * p[3], (s - 0.5) * p[4], (s - 0.5) * height); };
    cone(at(low), at(high), std::lerp(ra, rb, low), std::lerp(ra, rb, high));
  }

  /// Calls visit(i, cosine, sine) for the ends of so many equal parts of a sweep, without `lost` radians at either end.
  template <class Visit>
  static void for_each_step(double sweep, double lost, int steps, const Visit& visit) {
    const double step = (sweep - 2.0 * lost) / steps, step_x = std::cos(step), step_y = std::sin(step);
    double x = std::cos(lost), y = std::sin(lost);
    for (int i = 0; i <= steps; ++i) {
      visit(i, x, y);
      const double next = x * step_x - y * step_y;
      y = x * step_y + y * step_x, x = next;
    }
  }
  /// `thickness`: half of what is swept, as a share of the radius of the sweep.
  static int steps_of(double sweep, double thickness) {
    const double step = std::clamp(std::sqrt(8.0 * kSagitta * thickness), kLeastStep, kMostStep);
    return std::max(1, int(std::ceil(sweep / step)));
  }

  /// A strip across the direction in which the tube is seen. A chord of the centre line leaves it by up to `sagitta`.
  void circular_torus(double major, double tube, double sweep) {
    if (!(major > tube) || !(sweep > 0.0)) return;
    const int steps = steps_of(sweep, tube / major);
    const double sagitta = major * (1.0 - std::cos(0.5 * sweep / steps));
    const double r = tube - of_radius_ * (4.0 * tube + 0.025 * major) - lost_ - sagitta;
    const double lost = of_radius_ * sweep + lost_ / major;
    if (!(r > 0.0 && 2.0 * lost < sweep)) return;
    dvec3 last(0.0), last_w(0.0);
    for_each_step(sweep, lost, steps, [&](int i, double x, double y) {
      const dvec3 at(major * x, major * y, 0.0), across = glm::cross(dvec3(-y, x, 0.0), seen(at));
      const double size = glm::length(across);
      dvec3 w = size > 0.0 ? across * (r / size) : dvec3(0.0);
      if (i > 0) {
        if (glm::dot(w, last_w) < 0.0) w = -w;
        quad(last - last_w, at - w, at + w, last + last_w);
      }
      last = at, last_w = w;
    });
  }

  /// Its middle surfaces: a ring, and a band half way between the radii.
  void rectangular_torus(double inner, double outer, double height, double sweep) {
    if (!(sweep > 0.0 && outer > inner)) return;
    const int steps = steps_of(sweep, 0.5 * (outer - inner) / outer);
    const double lost = of_radius_ * outer + lost_, chord = std::cos(0.5 * sweep / steps);
    const double near = (inner + lost) / chord, far = outer - lost, middle = 0.5 * (near + far),
                 half = 0.5 * height - lost;
    const double lost_angle = of_radius_ * sweep + lost_ / near;
    if (!(far > near && half > 0.0 && 2.0 * lost_angle < sweep)) return;
    dvec3 last(0.0);
    const dvec3 up(0.0, 0.0, half);
    for_each_step(sweep, lost_angle, steps, [&](int i, double x, double y) {
      const dvec3 at(x, y, 0.0);
      if (i > 0) {
        quad(near * last, far * last, far * at, near * at);
        quad(middle * last - up, middle * at - up, middle * at + up, middle * last + up);
      }
      last = at;
    });
  }

  /// The circle of its base, and what is seen of its profile: as wide as `radius` at height 0 and `middle` at 0.6 of
  /// the height. Both shrink towards a point within and rise above the base by `lost`, and shares of the lengths.
  void dish(double radius, double middle, double height, double lost) {
    if (!(radius > 0.0 && height > 0.0)) return;
    const double rise = of_radius_ * height + lost;
    const double share = std::min(1.0 - of_radius_ - lost / radius, 1.0 - 2.0 * rise / height), r = share * radius;
    if (!(share > 0.0)) return;
    const dvec3 base(0.0, 0.0, rise);
    disc(base, {r, 0.0, 0.0}, {0.0, r, 0.0});
    const dvec3 v = seen(dvec3(0.0, 0.0, 0.5 * height));
    const double across = length(v.x, v.y);
    if (!(across > 0.0)) return;
    const dvec3 w(-v.y / across, v.x / across, 0.0), up(0.0, 0.0, share * height), m = share * middle * w;
    append(5).corners = {from_eye(base - r * w), from_eye(base + r * w), from_eye(base + m + 0.6 * up),
                         from_eye(base + up), from_eye(base - m + 0.6 * up)};
  }

  /// A half ellipsoid that shrinks by `lost` towards the point so far above the middle of its base keeps the distance
  /// sqrt(2/3) lost from its surface: least at the equator's side, where its height is twice its radius.
  static constexpr double kEllipse = 1.2247448713915890491;  // sqrt(3/2)

  void spherical_dish(double base, double height) {
    if (!(base > 0.0 && height > 0.0)) return;
    const double radius = 0.5 * (base * base + height * height) / height, at = 0.6 * height - (height - radius);
    dish(base, std::sqrt(std::max(0.0, radius * radius - at * at)), height, lost_);
  }

  void sphere(double radius) {
    const double r = within(radius);
    if (!(r > 0.0)) return;
    const dvec3 v = seen(dvec3(0.0));
    const dvec3 u = glm::cross(v, std::abs(v.x) < std::abs(v.y) ? dvec3(1, 0, 0) : dvec3(0, 1, 0)),
                w = glm::cross(v, u);
    const double first = glm::length(u), second = glm::length(w);
    if (first > 0.0 && second > 0.0) disc(dvec3(0.0), u * (r / first), w * (r / second));
  }

  /// In front of the cylinder about the line from a to b, longer by `beyond` at both ends: the rectangle through which
  /// the eye sees it, in the plane that touches it along the line nearest to the eye. The outline gives the rectangle's
  /// width, and where lines of sight to the ends cross the plane its length.
  bool front(dvec3 a, const dvec3& b, double radius, double beyond) {
    const double distance = glm::length(b - a);
    if (!(distance > 0.0)) return false;
    const dvec3 along = (b - a) / distance;
    const double lost = of_radius_ * radius + lost_, r = radius + lost;
    a -= (beyond + lost) * along;
    const double end = distance + 2.0 * (beyond + lost);
    // To the eye, from a: so far along the cylinder, and so high over its axis.
    const dvec3 to_eye = perspective_ ? eye_ - a : -eye_;
    const double at = glm::dot(to_eye, along);
    const dvec3 across = to_eye - at * along;
    const double height = glm::length(across);
    double low = 0.0, high = end, half = r;
    if (perspective_) {
      if (!(height > kLeastHeight * r)) return false;
      const double nearer = (height - r) / (height + r), moved = 1.0 - nearer;
      low = std::min(0.0, at * moved), high = end + std::max(0.0, (at - end) * moved);
      half *= std::sqrt(nearer);
    } else {
      if (!(height > 0.0)) return false;
      const double moved = 2.0 * r * at / height;
      low = std::min(0.0, moved), high = end + std::max(0.0, moved);
    }
    if (!(high - low < kLongest * (end + r))) return false;
    const dvec3 up = across / height, w = half * glm::cross(along, up);
    const dvec3 from = a + r * up + low * along, to = a + r * up + high * along;
    quad(from - w, from + w, to + w, to - w);
    return true;
  }
  static constexpr double kLeastHeight = 1.05;  // of the eye over the axis, in radii
  static constexpr double kLongest = 4.0;       // of a rectangle, in lengths of its solid: else it tells little

  /// None where it leans or has slanted ends, whose cone goes on widening beyond its height.
  bool front_of_snout(const std::array<double, 9>& p) {
    if (std::any_of(p.begin() + 3, p.end(), [](double of) { return of != 0.0; })) return false;
    const double half = 0.5 * std::abs(p[2]);
    return front({0.0, 0.0, -half}, {0.0, 0.0, half}, std::max(std::abs(p[0]), std::abs(p[1])), 0.0);
  }

  /// Tests the fronts of cylinders about chords, each of which contains its part of the tube.
  bool fronts_of_torus(double major, double tube, double sweep) {
    if (!(major > tube) || !(sweep > 0.0)) return false;
    const int steps = std::max(1, int(std::ceil(sweep / kFrontStep)));
    const double half = 0.5 * sweep / steps, sagitta = major * (1.0 - std::cos(half)), beyond = tube * std::sin(half);
    dvec3 last(0.0);
    bool all = true;
    for_each_step(sweep, 0.0, steps, [&](int i, double x, double y) {
      const dvec3 point(major * x, major * y, 0.0);
      if (i > 0) all = all && front(last, point, tube + sagitta, beyond);
      last = point;
    });
    return all;
  }
  static constexpr double kFrontStep = 0.5;  // radians

  Kind kind_;
  std::array<double, 9> parameters_;
  Affine eye_from_item_;
  bool perspective_;
  dvec3 eye_;  // or the direction
  double of_radius_, lost_;
  std::vector<OccluderPolygon>& out_;
};

/// None for lines, meshes and singular placements.
std::optional<InnerOccluders> inner_occluders_of(Kind kind, const float* parameters, const Affine& eye_from_item,
                                                 const EyeProjection& projection, double of_radius, double metres,
                                                 std::vector<OccluderPolygon>& out) {
  if (int(kind) >= core::kPrimitiveKindCount || kind == Kind::kLine) return std::nullopt;
  std::array<double, 9> p{};
  for (int i = 0; i < core::parameter_count(kind); ++i) p[std::size_t(i)] = double(parameters[i]);
  constexpr double kLeast = 1e-200, kMost = 1e200;
  const double volume = std::abs(glm::determinant(eye_from_item.linear));
  if (!(volume > kLeast && volume < kMost)) return std::nullopt;
  return InnerOccluders(kind, p, eye_from_item, glm::inverse(eye_from_item.linear), projection, of_radius, metres, out);
}

}  // namespace

void add_inner_occluders(Kind kind, const float* parameters, const Affine& eye_from_item,
                         const EyeProjection& projection, double of_radius, double metres,
                         std::vector<OccluderPolygon>& polygons) {
  if (auto item = inner_occluders_of(kind, parameters, eye_from_item, projection, of_radius, metres, polygons))
    item->add();
}

bool add_fronts(Kind kind, const float* parameters, const Affine& eye_from_item, const EyeProjection& projection,
                double of_radius, double metres, std::vector<OccluderPolygon>& fronts) {
  auto item = inner_occluders_of(kind, parameters, eye_from_item, projection, of_radius, metres, fronts);
  return item && item->add_fronts();
}

}  // namespace sightline::culling
