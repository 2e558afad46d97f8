#include "sightline/importers/plant/internal/plant_equipment.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace sightline::importers::plant {
namespace {

constexpr double kRail = 0.021, kRailCorner = 0.1;
constexpr dvec3 kX{1, 0, 0}, kY{0, 1, 0};
constexpr std::array<dvec3, 4> kSides{dvec3(1, 0, 0), dvec3(0, 1, 0), dvec3(-1, 0, 0), dvec3(0, -1, 0)};

double lerp(double a, double b, int i, int n) {
  return a + (b - a) * i / n;
}

/// Number of pieces of at most `longest` that make up a length.
int pieces(double length, double longest) {
  return std::max(1, int(std::ceil(length / longest - 1e-9)));
}

/// A rail around a rectangle whose corners are quarter bends; the pieces meet end to end.
void add_rail(Stage& stage, const dvec3& low, const dvec3& high, double z) {
  const double r = kRailCorner;
  const std::array<dvec3, 4> corners{dvec3(high.x, low.y, z), dvec3(high.x, high.y, z), dvec3(low.x, high.y, z),
                                     dvec3(low.x, low.y, z)};
  for (int i = 0; i < 4; ++i) {
    const dvec3 &along = kSides[std::size_t(i)], &next = kSides[std::size_t(i + 1) % 4];
    const dvec3& corner = corners[std::size_t(i)];
    const dvec3& previous = corners[std::size_t(i + 3) % 4];
    add_cylinder(stage, previous + r * along, corner - r * along, kRail);
    const dmat3 axes(-next, along, glm::cross(-next, along));
    stage.add(core::CircularTorus{mm(r), mm(kRail), float(kPi / 2)}, Frame{axes, corner + r * (next - along)});
  }
}

/// A nozzle with its flange, and a blind pipe end behind it.
void add_nozzle(Stage& stage, const dvec3& wall, const dvec3& out, double radius) {
  PipeRun nozzle(stage, wall, out, radius);
  nozzle.straight(2.0 * radius + 0.1);
  nozzle.flange(0.3 * radius + 0.01, 1.7 * radius);
  nozzle.flange(0.3 * radius + 0.01, 1.7 * radius);
}

void add_ring_platform(Stage& stage, const dvec3& centre, double vessel_radius) {
  const double inner = vessel_radius + 0.03, outer = vessel_radius + 1.1;
  for (const double sign : {1.0, -1.0}) {
    const dmat3 axes(sign * kX, sign * kY, kUp);
    stage.add(core::RectangularTorus{mm(inner), mm(outer), mm(0.05), float(kPi)}, Frame{axes, centre});
  }
  for (const double z : {0.55, 1.1}) add_ring(stage, centre + z * kUp, kUp, outer - 0.05, kRail);
  for (int i = 0; i < 8; ++i) {
    const dvec3 side = kSides[std::size_t(i / 2)], next = kSides[std::size_t(i / 2 + 1) % 4];
    const dvec3 foot = centre + (outer - 0.05) * (i % 2 == 0 ? side : kHalfSqrt2 * (side + next));
    add_cylinder(stage, foot, foot + 1.1 * kUp, kRail);
  }
}

}  // namespace

// --- steel -----------------------------------------------------------------------------------------------------------

std::int64_t steel_frame_cost(const SteelGrid& grid, std::size_t levels) {
  const std::int64_t nx = grid.bays_x + 1, ny = grid.bays_y + 1;
  return nx * ny + std::int64_t(levels) * (nx + ny);
}

void add_steel_frame(Stage& stage, const SteelGrid& grid, std::span<const double> levels) {
  constexpr double kHalf = 0.12, kDepth = 0.3;
  const dvec3 &low = grid.block.min, &high = grid.block.max;
  const double top = levels.back();
  for (int i = 0; i <= grid.bays_x; ++i) {
    const double x = lerp(low.x + kHalf, high.x - kHalf, i, grid.bays_x);
    stage.branch();
    for (int j = 0; j <= grid.bays_y; ++j) {
      const double y = lerp(low.y + kHalf, high.y - kHalf, j, grid.bays_y);
      add_block(stage, {x - kHalf, y - kHalf, 0.0}, {x + kHalf, y + kHalf, top});
    }
    for (const double z : levels) add_block(stage, {x - 0.1, low.y, z - kDepth}, {x + 0.1, high.y, z});
  }
  stage.branch();
  for (int j = 0; j <= grid.bays_y; ++j) {
    const double y = lerp(low.y + kHalf, high.y - kHalf, j, grid.bays_y);
    for (const double z : levels) add_block(stage, {low.x, y - 0.1, z - 2.0 * kDepth}, {high.x, y + 0.1, z - kDepth});
  }
}

void add_handrail(Stage& stage, const dvec3& low, const dvec3& high) {
  const double z = low.z;
  for (const double height : {0.55, 1.1}) add_rail(stage, low, high, z + height);
  const auto post = [&](double x, double y) { add_cylinder(stage, {x, y, z}, {x, y, z + 1.1}, kRail); };
  const double inset = 2.0 * kRailCorner;
  const int nx = pieces(high.x - low.x, 1.5), ny = pieces(high.y - low.y, 1.5);
  for (int i = 0; i <= nx; ++i)
    for (const double y : {low.y, high.y}) post(lerp(low.x + inset, high.x - inset, i, nx), y);
  for (int i = 0; i <= ny; ++i)
    for (const double x : {low.x, high.x}) post(x, lerp(low.y + inset, high.y - inset, i, ny));
}

void add_platform(Stage& stage, const dvec3& low, const dvec3& high) {
  const int panels = pieces(high.x - low.x, 2.0);
  stage.branch();
  for (int i = 0; i < panels; ++i)
    add_block(stage, {lerp(low.x, high.x, i, panels) + 0.005, low.y, low.z - 0.04},
              {lerp(low.x, high.x, i + 1, panels) - 0.005, high.y, low.z});
  stage.branch();
  add_handrail(stage, low + dvec3(0.03, 0.03, 0), {high.x - 0.03, high.y - 0.03, low.z});
}

void add_stairs(Stage& stage, const dvec3& foot, double sign, double width, double rise) {
  constexpr double kStep = 0.2;  // a 3-4-5 triangle: no angle that needs a sine
  const dvec3 slope(0.8 * sign, 0.0, 0.6);
  const double length = rise / 0.6;
  const dmat3 axes(slope, sign * kY, glm::cross(slope, sign * kY));
  stage.branch();
  const int steps = int(rise / kStep);
  for (int i = 1; i <= steps; ++i) {
    const double up = i * kStep;
    add_box(stage, foot + dvec3(sign * up * 4.0 / 3.0, 0.0, up), {0.27, width, 0.03});
  }
  stage.branch();
  for (const double side : {-0.5, 0.5}) {
    const dvec3 start = foot + side * width * kY;
    add_box(stage, Frame{axes, start + 0.5 * length * slope + 0.1 * kUp}, {length, 0.02, 0.2});
    for (const double height : {0.55, 1.0})
      add_cylinder(stage, start + height * kUp, start + length * slope + height * kUp, kRail);
    for (int i = 0; i <= 3; ++i) {
      const dvec3 post = start + lerp(0.05, 0.95, i, 3) * length * slope;
      add_cylinder(stage, post, post + 1.0 * kUp, kRail);
    }
  }
}

void add_ladder(Stage& stage, const dvec3& foot, const dvec3& outwards, double height) {
  const dvec3 aside = glm::cross(kUp, outwards);
  stage.branch();
  for (const double side : {-0.2, 0.2})
    add_cylinder(stage, foot + side * aside, foot + side * aside + height * kUp, kRail);
  for (double z = 0.3; z < height; z += 0.3)
    add_cylinder(stage, foot - 0.2 * aside + z * kUp, foot + 0.2 * aside + z * kUp, 0.01);
}

void add_cable_tray(Stage& stage, const dvec3& from, const dvec3& along, double length) {
  const int count = pieces(length, 3.0);
  const dvec3 aside(along.y, along.x, 0.0);
  const double piece = length / count;
  for (int i = 0; i < count; ++i) {
    const dvec3 centre = from + (i + 0.5) * piece * along;
    const auto part = [&](double shift, double lift, double width, double height) {
      add_box(stage, centre + shift * aside + lift * kUp,
              glm::abs(along) * (piece - 0.01) + glm::abs(aside) * width + height * kUp);
    };
    part(0.0, 0.0, 0.4, 0.01);
    part(-0.2, 0.05, 0.01, 0.1);
    part(0.2, 0.05, 0.01, 0.1);
  }
}

void add_duct(Stage& stage, const dvec3& from, double length, double size) {
  const double inner = 0.5 * size, middle = inner + 0.5 * size, first = length - middle - 0.5 * size;
  add_box(stage, from + 0.5 * first * kX, {first, size, size});
  // From +x to +y around a centre on the left: the arc starts below the centre.
  const dvec3 bend = from + first * kX + middle * kY;
  stage.add(core::RectangularTorus{mm(inner), mm(inner + size), mm(size), float(kPi / 2)},
            Frame{dmat3(-kY, kX, kUp), bend});
  add_box(stage, bend + middle * kX + 0.5 * middle * kY, {size, middle, size});
}

// --- vessels ---------------------------------------------------------------------------------------------------------

void add_column(Stage& stage, Random& random, const dvec3& foot, double radius, double height) {
  const double skirt = std::min(1.5, 0.2 * height), head = 0.5 * radius, shell = height - skirt - head;
  const bool tapers = radius > 0.8 && random.chance(0.5);
  const double upper = tapers ? 0.75 * radius : radius;
  stage.branch();
  add_snout(stage, foot, kUp, skirt, {1.15 * radius, radius});
  add_dish(stage, foot + skirt * kUp, -kUp, 0.98 * radius, 0.4 * radius);
  const dvec3 base = foot + skirt * kUp, middle = base + 0.6 * shell * kUp, top = base + shell * kUp;
  if (tapers) {
    const double cone = 0.1 * shell;
    add_cylinder(stage, base, middle, radius);
    add_snout(stage, middle, kUp, cone, {radius, upper});
    add_cylinder(stage, middle + cone * kUp, top, upper);
  } else {
    add_cylinder(stage, base, top, radius);
  }
  add_dish(stage, top, kUp, upper, 0.5 * upper);
  stage.branch();
  const double nozzle = std::min(0.2, 0.15 * radius);
  for (const dvec3& side : kSides) {
    const dvec3 wall = base + random.between(0.05, 0.55) * shell * kUp + (radius - 0.02) * side;
    add_nozzle(stage, wall, side, nozzle);
  }
  if (height < 8.0 || radius < 0.5) return;
  stage.branch();
  for (double z = 5.0; z < shell - 1.5; z += 6.0)
    add_ring_platform(stage, base + z * kUp, z > 0.55 * shell ? std::max(upper, radius) : radius);
  add_ladder(stage, base + (radius + 0.25) * kX, kX, shell - 1.0);
}

void add_drum(Stage& stage, Random& random, const dvec3& foot, double radius, double length) {
  const double lift = radius + 0.6;
  const dvec3 left = foot + lift * kUp - 0.5 * length * kX, right = left + length * kX;
  stage.branch();
  add_cylinder(stage, left, right, radius);
  add_dish(stage, left, -kX, radius, 0.5 * radius);
  add_dish(stage, right, kX, radius, 0.5 * radius);
  for (const double at : {-0.3, 0.3}) {
    const dvec3 under = foot + at * length * kX;
    add_block(stage, under - dvec3(0.12, 0.85 * radius, 0.0), under + dvec3(0.12, 0.85 * radius, 0.7 + 0.2 * radius));
  }
  stage.branch();
  for (const double at : {-0.35, 0.0, 0.35}) {
    const dvec3 wall = foot + at * length * kX + (lift + radius - 0.02) * kUp;
    add_nozzle(stage, wall, kUp, std::min(0.2, radius * random.between(0.08, 0.2)));
  }
}

void add_tank(Stage& stage, Random& random, const dvec3& foot, double radius, double height) {
  const double wall = 0.85 * height;
  stage.branch();
  add_cylinder(stage, foot, foot + wall * kUp, radius);
  add_dish(stage, foot + wall * kUp, kUp, radius, 0.15 * radius, true);
  for (const double z : {0.3, 0.6})  // stiffening rings
    add_ring(stage, foot + z * wall * kUp, kUp, radius, 0.04);
  stage.branch();
  for (const dvec3& side : kSides)
    add_nozzle(stage, foot + 0.5 * kUp + (radius - 0.02) * side, side,
               std::min(0.2, radius * random.between(0.04, 0.1)));
  if (height > 3.0) add_ladder(stage, foot + (radius + 0.2) * kX, kX, wall);
}

void add_sphere_tank(Stage& stage, const dvec3& foot, double radius) {
  const dvec3 centre = foot + 1.4 * radius * kUp;
  stage.branch();
  stage.add(core::Sphere{mm(2.0 * radius)}, Frame{dmat3(1.0), centre});
  for (int i = 0; i < 8; ++i) {
    const dvec3 side = kSides[std::size_t(i / 2)], next = kSides[std::size_t(i / 2 + 1) % 4];
    const dvec3 leg = foot + 0.97 * radius * (i % 2 == 0 ? side : kHalfSqrt2 * (side + next));
    add_cylinder(stage, leg, leg + 1.45 * radius * kUp, 0.06 * radius);
  }
  add_nozzle(stage, centre + 0.99 * radius * kUp, kUp, 0.06 * radius);
}

void add_pump(Stage& stage, const dvec3& foot, double size) {
  const dvec3 axis = foot + 0.55 * size * kUp;
  stage.branch();
  add_block(stage, foot - dvec3(size, 0.4 * size, 0.0), foot + dvec3(size, 0.4 * size, 0.15 * size));
  add_cylinder(stage, axis - 0.85 * size * kX, axis - 0.05 * size * kX, 0.3 * size);  // motor
  add_box(stage, axis - dvec3(0.45 * size, 0.0, -0.35 * size), dvec3(0.3, 0.25, 0.15) * size);
  add_cylinder(stage, axis - 0.05 * size * kX, axis + 0.3 * size * kX, 0.06 * size);  // shaft
  add_cylinder(stage, axis + 0.3 * size * kX, axis + 0.55 * size * kX, 0.4 * size);   // casing
  add_snout(stage, axis + 0.55 * size * kX, kX, 0.25 * size, {0.3 * size, 0.15 * size});
  add_cylinder(stage, axis + 0.8 * size * kX, axis + 0.95 * size * kX, 0.15 * size);
  PipeRun outlet(stage, axis + 0.42 * size * kX + 0.38 * size * kUp, kUp, 0.1 * size);
  outlet.straight(0.3 * size);
  outlet.flange(0.05 * size, 0.2 * size);
  outlet.flange(0.05 * size, 0.2 * size);
  outlet.straight(0.2 * size);
  outlet.turn(kX);
  outlet.straight(0.5 * size);
}

void add_hopper(Stage& stage, const dvec3& foot, double size) {
  const double legs = 0.8 * size;
  stage.branch();
  stage.add(core::Pyramid{mm(0.2 * size), mm(0.2 * size), mm(size), mm(size), mm(0.1 * size), 0, mm(0.9 * size)},
            Frame{dmat3(1.0), foot + (legs + 0.15 * size) * kUp});
  add_block(stage, foot + dvec3(-0.45 * size, -0.5 * size, legs + 0.6 * size),
            foot + dvec3(0.55 * size, 0.5 * size, legs + 1.0 * size));
  for (const double x : {-0.4, 0.5})
    for (const double y : {-0.45, 0.45})
      add_block(stage, foot + dvec3(x * size - 0.05, y * size - 0.05, 0.0),
                foot + dvec3(x * size + 0.05, y * size + 0.05, legs + 0.6 * size));
}

void add_paving(Stage& stage, const dvec3& low, const dvec3& high) {
  const float x = mm(0.5 * (high.x - low.x)), y = mm(0.5 * (high.y - low.y));
  core::Mesh mesh;
  mesh.name = "paving";
  mesh.positions = {{-x, -y, 0},
                    {x, -y, 0},
                    {x, y, 0},
                    {-x, y, 0},
                    {-0.2f * x, -0.2f * y, 0},
                    {-0.2f * x, 0.2f * y, 0},
                    {0.2f * x, 0.2f * y, 0},
                    {0.2f * x, -0.2f * y, 0}};
  mesh.normals.assign(8, core::vec3(0, 0, 1));
  // The ring between the outer rectangle and the (clockwise) opening: vertices 4 … 7 lie at its four corners.
  mesh.indices = {0, 1, 7, 0, 7, 4, 1, 2, 6, 1, 6, 7, 2, 3, 5, 2, 5, 6, 3, 0, 4, 3, 4, 5};
  mesh.contour_sizes = {4, 4};
  mesh.polygon_contours = {2};
  const dvec3 centre(0.5 * (low.x + high.x), 0.5 * (low.y + high.y), low.z);
  stage.branch();
  stage.add_mesh(stage.scene().add_mesh(std::move(mesh)).value(), Frame{dmat3(1.0), centre});
  for (const double side : {-1.0, 1.0})
    stage.add(core::Line{-x, x}, Frame{dmat3(1.0), centre + dvec3(0.0, side * double(y) * 0.001, 0.0)});
}

}  // namespace sightline::importers::plant
