#include "sightline/gpuprims/internal/joints.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cassert>
#include <cmath>
#include <cstring>

#include "sightline/core/internal/access.h"
#include "sightline/core/internal/prefetch.h"
#include "sightline/core/internal/radix_sort.h"

namespace sightline::gpuprims {

using core::Affine;
using core::dvec3;
using core::ItemId;
using core::Kind;
using core::Primitive;
using core::Slot;
using core::Snapshot;

namespace {

using core::length_of;

constexpr std::uint32_t kItemsPerWord = 32;

/// An end in local units: its contour, and any vector that leaves the solid through the end.
struct LocalEnd {
  dvec3 centre, u, v, outwards;
};
using Found = std::optional<LocalEnd>;

Found disc(const dvec3& centre, const dvec3& u, const dvec3& v, const dvec3& outwards) {
  return LocalEnd{centre, u, v, outwards};
}

Found local_end(const core::Cylinder& c, bool top) {
  const double r = length_of(c.radius), side = top ? 1.0 : -1.0;
  if (c.height == 0.0f) return std::nullopt;
  return disc({0.0, 0.0, 0.5 * side * length_of(c.height)}, {r, 0.0, 0.0}, {0.0, r, 0.0}, {0.0, 0.0, side});
}

Found local_end(const core::CircularTorus& t, bool top) {
  const double r = length_of(t.tube_radius), major = length_of(t.major_radius), angle = core::sweep_angle(t.angle);
  if (angle == core::kFullTurn || angle == 0.0 || r > major) return std::nullopt;
  const dvec3 out = top ? dvec3(std::cos(angle), std::sin(angle), 0.0) : dvec3(1.0, 0.0, 0.0);
  const dvec3 along(-out.y, out.x, 0.0);
  return disc(major * out, r * out, {0.0, 0.0, r}, top ? along : -along);
}

Found dish_base(float base_radius, float height, bool top) {
  const double r = length_of(base_radius);
  if (top || height == 0.0f) return std::nullopt;
  return disc(dvec3(0.0), {r, 0.0, 0.0}, {0.0, r, 0.0}, {0.0, 0.0, -1.0});
}
Found local_end(const core::EllipticalDish& d, bool top) {
  return dish_base(d.base_radius, d.height, top);
}
Found local_end(const core::SphericalDish& d, bool top) {
  return dish_base(d.base_radius, d.height, top);
}

/// The cone has radius r + k z and leans by s z, where z is measured from the end's centre. Without the lean the plane
/// is z = (m / d) . q, d = 1 - m . s, and the section is symmetric about the direction of m. So one axis of the ellipse
/// runs between its highest and its lowest point, whose heights core::bottom_end_range() gives. The other axis is
/// level.
Found local_end(const core::Snout& s, bool top) {
  const double height = length_of(s.height), r = length_of(top ? s.top_radius : s.bottom_radius),
               side = top ? 0.5 : -0.5;
  if (height == 0.0) return std::nullopt;
  const dvec3 axis(s.offset_x, s.offset_y, height);
  Found end = disc(side * axis, {r, 0.0, 0.0}, {0.0, r, 0.0}, side * axis);
  if (s.bottom_shear_x == 0.0f && s.bottom_shear_y == 0.0f && s.top_shear_x == 0.0f && s.top_shear_y == 0.0f)
    return end;
  const core::EndRange below = core::bottom_end_range(s), above = core::top_end_range(s), range = top ? above : below;
  if (below.limited || above.limited || below.max - above.min >= height) return std::nullopt;
  const glm::dvec2 slant(std::tan(double(top ? s.top_shear_x : s.bottom_shear_x)),
                         std::tan(double(top ? s.top_shear_y : s.bottom_shear_y)));
  const double steepness = glm::length(slant);
  if (steepness == 0.0) return end;
  const double k = (length_of(s.top_radius) - length_of(s.bottom_radius)) / height;
  const glm::dvec2 uphill = slant / steepness, lean = glm::dvec2(axis) / height;
  const auto contour = [&](double z, double direction) {
    return dvec3(lean * z + direction * (r + k * z) * uphill, z);
  };
  const dvec3 highest = contour(range.max, 1.0), lowest = contour(range.min, -1.0);
  const double middle = 0.5 * (range.max + range.min), radius = r + k * middle,
               off_axis = 0.5 * k * (range.max - range.min);
  const double half_chord = std::sqrt(std::max(0.0, (radius - off_axis) * (radius + off_axis)));
  end->centre += 0.5 * (highest + lowest);
  end->u = 0.5 * (highest - lowest);
  end->v = half_chord * dvec3(-uphill.y, uphill.x, 0.0);
  return end;
}

template <class Other>
Found local_end(const Other&, bool) {
  return std::nullopt;
}

bool has_ends(Kind kind) {
  return kind == Kind::kCylinder || kind == Kind::kSnout || kind == Kind::kCircularTorus ||
         kind == Kind::kEllipticalDish || kind == Kind::kSphericalDish;
}

/// Larger half-axis of an ellipse from its conjugate half-diameters' squares and product.
double larger_half_axis(double uu, double vv, double uv) {
  return std::sqrt(0.5 * (uu + vv + std::sqrt((uu - vv) * (uu - vv) + 4.0 * uv * uv)));
}

/// An end face with the values that comparisons need.
struct Measured {
  explicit Measured(const EndFace& f) : face(f), normal(glm::cross(f.u, f.v)) {
    area = std::sqrt(glm::dot(normal, normal));
    normal *= 1.0 / area;
    radius = area / larger_half_axis(glm::dot(f.u, f.u), glm::dot(f.v, f.v), glm::dot(f.u, f.v));
  }
  EndFace face;
  dvec3 normal;
  double area, radius;  // |u x v|, smaller half-axis
};

bool covers(const Measured& other, const Measured& face) {
  const dvec3 apart = face.face.centre - other.face.centre;
  const double gap = kJointGap * face.radius;
  if (glm::dot(apart, apart) > gap * gap || glm::dot(other.normal, face.normal) >= 0.0) return false;
  const double rise_u = glm::dot(face.face.u, other.normal), rise_v = glm::dot(face.face.v, other.normal);
  if (std::abs(glm::dot(apart, other.normal)) + std::sqrt(rise_u * rise_u + rise_v * rise_v) > gap) return false;
  // In coordinates in which the other is the unit circle, the face's contour is an offset and a linear map of that
  // circle, which reaches as far as the map's largest singular value.
  const double scale = 1.0 / other.area;
  const dvec3 x = scale * glm::cross(other.face.v, other.normal), y = scale * glm::cross(other.normal, other.face.u);
  const auto flat = [&](const dvec3& v) { return glm::dvec2(glm::dot(v, x), glm::dot(v, y)); };
  const glm::dvec2 u = flat(face.face.u), v = flat(face.face.v), offset = flat(apart);
  return larger_half_axis(glm::dot(u, u), glm::dot(v, v), glm::dot(u, v)) + std::sqrt(glm::dot(offset, offset)) <=
         1.0 + kJointExcess * face.radius / other.radius;
}

std::optional<EndFace> in_world(const Found& local, const Affine& world_from_item) {
  if (!local) return std::nullopt;
  EndFace face{core::transform_point(world_from_item, local->centre), world_from_item.linear * local->u,
               world_from_item.linear * local->v};
  const double volume = glm::dot(glm::cross(face.u, face.v), world_from_item.linear * local->outwards);
  if (!(std::abs(volume) > 0.0)) return std::nullopt;
  if (volume < 0.0) std::swap(face.u, face.v);
  return face;
}

template <class P>
std::optional<EndFace> face_of(const P& primitive, const Affine& world_from_item, Ends end) {
  return in_world(local_end(primitive, end == kTopEnd), world_from_item);
}

}  // namespace

std::optional<EndFace> end_face(const Primitive& primitive, const Affine& world_from_item, Ends end) {
  return std::visit([&](const auto& p) { return face_of(p, world_from_item, end); }, primitive);
}

bool covers(const EndFace& other, const EndFace& face) {
  return covers(Measured(other), Measured(face));
}

namespace {

/// By material: whether it is opaque.
std::vector<bool> opaque_materials(const Snapshot& snapshot) {
  std::vector<bool> opaque;
  for (const glm::vec4& material : snapshot.materials()) opaque.push_back(material.a >= 1.0f);
  return opaque;
}

/// Appends those slots of `items` that are below `former_size` and not among the `touched` yet, each once.
void add_slots(const Snapshot& snapshot, std::span<const ItemId> items, std::size_t former_size,
               std::vector<Slot>& touched) {
  if (items.empty()) return;
  std::vector<Slot> others;
  for (const ItemId item : items)
    if (const Slot s = snapshot.slot(item); s < former_size) others.push_back(s);  // kNone is above
  core::radix_sort(others);
  others.erase(std::unique(others.begin(), others.end()), others.end());
  // Neighbours that were edited themselves are in `touched` already.
  std::vector<bool> known(others.size());
  for (const Slot s : touched) {
    const auto at = std::lower_bound(others.begin(), others.end(), s);
    if (at != others.end() && *at == s) known[std::size_t(at - others.begin())] = true;
  }
  for (std::size_t i = 0; i < others.size(); ++i)
    if (!known[i]) touched.push_back(others[i]);
}

}  // namespace

// --- finding ---------------------------------------------------------------------------------------------------------

/// Sorts ends by the cell of their centre; an end near a cell border goes into all cells within its tolerance. Then
/// compares the ends that meet in a cell, in slot order. Slots are in spatial order, so that computing faces again from
/// the snapshot costs less than storing them.
class JointSearch {
 public:
  JointSearch(const Snapshot& snapshot, Joints& out) : snapshot_(snapshot), out_(out) {}

  void run() {
    choose_cell();
    for (const std::uint64_t pair : pairs(ends())) compare(std::uint32_t(pair >> 32), std::uint32_t(pair));
    finish();
  }

 private:
  static constexpr std::size_t kMostLooked = 64;  // most ends of a cell that one end is compared with
  static constexpr double kCellGaps = 200.0;      // cell width, in gaps of a face of the usual size
  static constexpr double kMostGaps = 50.0;

  bool may_join(Slot s) const { return has_ends(snapshot_.kind(s)) && !snapshot_.vacant(s) && snapshot_.opaque(s); }

  /// Derives the cell width from the median size of a sample.
  void choose_cell() {
    constexpr std::size_t kSample = 1024;
    std::vector<double> sizes;
    const std::size_t step = std::max<std::size_t>(1, snapshot_.size() / kSample);
    for (std::size_t s = 0; s < snapshot_.size(); s += step)
      if (may_join(Slot(s)))
        if (const auto face = face_at(Slot(s), kBottomEnd)) sizes.push_back(Measured(*face).radius);
    double usual = 1.0;
    if (!sizes.empty()) {
      const auto middle = sizes.begin() + std::ptrdiff_t(sizes.size() / 2);
      std::nth_element(sizes.begin(), middle, sizes.end());
      usual = *middle;
    }
    most_apart_ = kMostGaps * kJointGap * usual;
    cells_per_unit_ = 1.0 / (kCellGaps * kJointGap * usual);
  }

  template <class P>
  std::optional<EndFace> face_as(Slot s, Ends end) const {
    const Kind kind = core::kind_of(Primitive(P{}));
    P primitive;
    std::memcpy(&primitive,
                snapshot_.of_kind(kind).parameters.data() + snapshot_.index_in_kind(s) * (sizeof(P) / sizeof(float)),
                sizeof(P));
    return face_of(primitive, snapshot_.world_from_item(s), end);
  }
  std::optional<EndFace> face_at(Slot s, Ends end) const {
    switch (snapshot_.kind(s)) {
      case Kind::kCylinder:
        return face_as<core::Cylinder>(s, end);
      case Kind::kCircularTorus:
        return face_as<core::CircularTorus>(s, end);
      case Kind::kSnout:
        return face_as<core::Snout>(s, end);
      default:
        return end_face(snapshot_.primitive(s), snapshot_.world_from_item(s), end);
    }
  }

  using Cell = std::array<std::int64_t, 3>;

  /// Without std::floor, which is a function call where the instruction set has no floor.
  Cell cell_of(const dvec3& p) const {
    Cell cell;
    for (int axis = 0; axis < 3; ++axis) {
      const double c = p[axis] * cells_per_unit_;
      const std::int64_t towards_zero = std::int64_t(c);
      cell[std::size_t(axis)] = towards_zero - (c < double(towards_zero));
    }
    return cell;
  }
  /// A 32-bit hash.
  static std::uint64_t hash_of(const Cell& cell) {
    std::uint64_t h = 0;
    for (const std::int64_t c : cell) {
      h = (h ^ std::uint64_t(c)) * 0x9e3779b97f4a7c15u;
      h ^= h >> 29;
    }
    return h >> 32;
  }
  /// False where doubles are no finer than a cell.
  bool within_grid(const dvec3& p) const {
    constexpr double kFarthest = 0x1p50;
    const double reach = kFarthest / cells_per_unit_;
    return std::abs(p.x) < reach && std::abs(p.y) < reach && std::abs(p.z) < reach;
  }

  /// All ends, each as hash of a cell << 32 | slot << 1 | whether it is the top.
  std::vector<std::uint64_t> ends() const {
    std::vector<std::uint64_t> keys;
    std::size_t most = 0;
    for (const Kind kind :
         {Kind::kCylinder, Kind::kSnout, Kind::kCircularTorus, Kind::kEllipticalDish, Kind::kSphericalDish})
      most += 2 * snapshot_.of_kind(kind).size();
    keys.reserve(most + most / 16);
    for (Slot s = 0; s < snapshot_.size(); ++s) {
      if (!may_join(s)) continue;
      for (const Ends end : {kBottomEnd, kTopEnd}) {
        const auto face = face_at(s, end);
        if (!face || !within_grid(face->centre)) continue;
        const double size2 = std::min(glm::dot(face->u, face->u), glm::dot(face->v, face->v));
        const double apart = std::min(kJointGap * std::sqrt(size2), most_apart_);  // no half-axis is larger
        const Cell low = cell_of(face->centre - apart), high = cell_of(face->centre + apart);
        for (std::int64_t x = low[0]; x <= high[0]; ++x)
          for (std::int64_t y = low[1]; y <= high[1]; ++y)
            for (std::int64_t z = low[2]; z <= high[2]; ++z)
              keys.push_back(hash_of({x, y, z}) << 32 | s << 1 | std::uint64_t(end == kTopEnd));
      }
    }
    return keys;
  }

  /// All pairs of ends that meet in a cell, each end as slot << 1 | top, in rising order of the first.
  static std::vector<std::uint64_t> pairs(std::vector<std::uint64_t> keys) {
    core::radix_sort<32>(keys);
    std::vector<std::uint64_t> out;
    for (std::size_t i = 0; i < keys.size(); ++i) {
      const std::size_t end = std::min(keys.size(), i + kMostLooked);
      for (std::size_t k = i + 1; k < end && keys[k] >> 32 == keys[i] >> 32; ++k) {
        const std::uint32_t a = std::uint32_t(keys[i]), b = std::uint32_t(keys[k]);
        if (a >> 1 != b >> 1) out.push_back(std::uint64_t(std::max(a, b)) << 32 | std::min(a, b));
      }
    }
    core::radix_sort<32>(out);
    return out;
  }

  static Ends end_of(std::uint32_t slot_and_top) { return (slot_and_top & 1) != 0 ? kTopEnd : kBottomEnd; }

  void compare(std::uint32_t a, std::uint32_t b) {
    const Slot slot_a = a >> 1, slot_b = b >> 1;
    if (snapshot_.bounds().layers(slot_a) != snapshot_.bounds().layers(slot_b)) return;
    if (snapshot_.kind(slot_a) == Kind::kSphericalDish && snapshot_.kind(slot_b) == Kind::kSphericalDish) return;
    const Measured face_a(*face_at(slot_a, end_of(a))), face_b(*face_at(slot_b, end_of(b)));
    if (covers(face_b, face_a)) cover(slot_b, slot_a, end_of(a));
    if (covers(face_a, face_b)) cover(slot_a, slot_b, end_of(b));
  }

  void cover(Slot by, Slot slot, Ends end) {
    const ItemId item = snapshot_.item(slot);
    if (!out_.set(item, end, true)) return;
    out_.covers_.push_back(std::uint64_t(snapshot_.item(by)) << 32 | to_index(item) << 1 | (end == kTopEnd));
  }

  void finish() {
    auto& covers = out_.covers_;
    if (covers.empty()) return;
    core::radix_sort<32>(covers);
    covers.shrink_to_fit();
    out_.bits_.shrink_to_fit();
    const std::size_t groups = (covers.back() >> 32) / kItemsPerWord + 1;
    out_.first_.resize(groups + 1);
    for (std::size_t group = 0, at = 0; group <= groups; ++group) {
      while (at < covers.size() && (covers[at] >> 32) / kItemsPerWord < group) ++at;
      out_.first_[group] = std::uint32_t(at);
    }
  }

  const Snapshot& snapshot_;
  Joints& out_;
  double most_apart_ = 0.0, cells_per_unit_ = 1.0;
};

// --- answers ---------------------------------------------------------------------------------------------------------

const StoredJoints* stored_joints(const Snapshot& snapshot) {
  return static_cast<const StoredJoints*>(core::Access::of(snapshot).stored().get());
}

Joints::Joints(const Snapshot& snapshot) {
  const StoredJoints* stored = stored_joints(snapshot);
  std::vector<bool> opaque = opaque_materials(snapshot);
  if (stored && std::equal(opaque.begin(), opaque.end(), stored->opaque.begin(), stored->opaque.end(),
                           [](bool a, std::uint8_t b) { return a == (b != 0); })) {
    bits_.assign(stored->bits.begin(), stored->bits.end());
    covers_.assign(stored->covers.begin(), stored->covers.end());
    first_.assign(stored->first.begin(), stored->first.end());
    for (const std::uint64_t word : bits_) count_ += std::size_t(std::popcount(word));
  } else {
    JointSearch(snapshot, *this).run();
  }
  if (count_ > 0) opaque_ = std::move(opaque);
}

Joints Joints::of_slots(std::vector<std::uint64_t> bits) {
  Joints joints;
  joints.of_slots_ = true;
  joints.bits_ = std::move(bits);
  for (const std::uint64_t word : joints.bits_) joints.count_ += std::size_t(std::popcount(word));
  return joints;
}

StoredJoints Joints::stored(const Snapshot& snapshot) const {
  const std::vector<bool> opaque = opaque_materials(snapshot);
  return {{bits_.begin(), bits_.end()},
          {covers_.begin(), covers_.end()},
          {first_.begin(), first_.end()},
          {opaque.begin(), opaque.end()}};
}

/// Returns false when nothing changed.
bool Joints::set(ItemId item, Ends end, bool covered) {
  const std::size_t word = to_index(item) / kItemsPerWord;
  if (word >= bits_.size()) {
    if (!covered) return false;
    bits_.resize(word + 1);
  }
  const std::uint64_t bit = std::uint64_t(end) << 2 * (to_index(item) % kItemsPerWord);
  if (((bits_[word] & bit) != 0) == covered) return false;
  bits_[word] ^= bit;
  count_ += covered ? 1 : std::size_t(-1);
  return true;
}

Ends Joints::covered(ItemId item) const {
  assert(!of_slots_);
  return covered_at(to_index(item));
}

Ends Joints::covered_at(std::uint32_t index) const {
  const std::size_t word = index / kItemsPerWord;
  return word < bits_.size() ? Ends(bits_[word] >> 2 * (index % kItemsPerWord) & 3u) : kNoEnd;
}

void Joints::dissolve(const Snapshot& snapshot, std::initializer_list<std::span<const ItemId>> edited,
                      std::size_t former_size, std::vector<Slot>& touched) {
  if (count_ == 0) return;
  std::vector<ItemId> uncovered;
  for (const std::span<const ItemId> items : edited)
    for (std::size_t i = 0; i < items.size(); ++i) {
      if (i + core::kPrefetchAhead < items.size()) prefetch(items[i + core::kPrefetchAhead]);
      dissolve(items[i], uncovered);
    }
  add_slots(snapshot, uncovered, former_size, touched);
}

void Joints::dissolve_transparent(const Snapshot& snapshot, std::size_t former_size, std::vector<Slot>& touched) {
  if (count_ == 0) return;
  std::vector<bool> opaque = opaque_materials(snapshot);
  std::swap(opaque, opaque_);
  const auto turned = [&](std::uint32_t m) { return m < opaque.size() && opaque[m] && !opaque_[m]; };
  bool any = false;
  for (std::uint32_t m = 0; m < opaque_.size(); ++m) any = any || turned(m);
  std::vector<ItemId> uncovered;
  for (Slot s = 0; any && s < snapshot.size(); ++s) {
    const ItemId item = snapshot.item(s);
    if (item == core::kNoItem || !turned(snapshot.material(s))) continue;
    if (covered(item) != kNoEnd) uncovered.push_back(item);
    dissolve(item, uncovered);
  }
  add_slots(snapshot, uncovered, former_size, touched);
}

void Joints::prefetch(ItemId item) const {
  const std::size_t group = to_index(item) / kItemsPerWord;
  if (group + 1 < first_.size()) core::prefetch(covers_.data() + first_[group], sizeof(covers_[0]));
}

void Joints::dissolve(ItemId item, std::vector<ItemId>& uncovered) {
  set(item, kBottomEnd, false);
  set(item, kTopEnd, false);
  const std::size_t group = to_index(item) / kItemsPerWord;
  if (group + 1 >= first_.size()) return;
  const auto end = covers_.begin() + std::ptrdiff_t(first_[group + 1]);
  auto at = std::lower_bound(covers_.begin() + std::ptrdiff_t(first_[group]), end, std::uint64_t(item) << 32);
  for (; at != end && ItemId(*at >> 32) == item; ++at) {
    const ItemId other = ItemId(std::uint32_t(*at) >> 1);
    if (set(other, (*at & 1) != 0 ? kTopEnd : kBottomEnd, false)) uncovered.push_back(other);
  }
}

std::size_t Joints::memory_bytes() const {
  return (bits_.capacity() + covers_.capacity()) * 8 + first_.capacity() * 4 + opaque_.capacity() / 8;
}

}  // namespace sightline::gpuprims
