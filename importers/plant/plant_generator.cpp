#include "sightline/importers/plant/plant_generator.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <string>
#include <vector>

#include "sightline/importers/plant/internal/plant_equipment.h"
#include "sightline/importers/plant/internal/plant_pipes.h"
#include "sightline/importers/plant/internal/plant_stage.h"

namespace sightline::importers {
namespace {

using namespace plant;
using core::AabbD;

constexpr std::uint64_t kFewest = 1'000, kMost = 10'000'000, kFullArea = 100'000;
constexpr double kRackShare = 0.2;
constexpr double kWalkway = 0.7;  // metres wide, along the rack's edge

/// Materials. The first are pipe services.
enum Paint : int {
  kWater,
  kSteam,
  kGas,
  kAir,
  kOil,
  kAcid,
  kFireWater,
  kInstrument,
  kSteelGrey,
  kSafetyYellow,
  kVesselSilver,
  kVesselWhite,
  kPumpBlue,
  kConcrete,
  kPaintCount
};
constexpr int kServices = kSteelGrey;

std::array<core::MaterialId, kPaintCount> mix_paints(core::Scene& scene) {
  const std::array<std::pair<const char*, core::vec3>, kPaintCount> paints{{
      {"water green", {0.20f, 0.55f, 0.35f}},
      {"steam silver", {0.78f, 0.79f, 0.80f}},
      {"gas ochre", {0.80f, 0.62f, 0.22f}},
      {"air blue", {0.55f, 0.72f, 0.85f}},
      {"oil brown", {0.47f, 0.33f, 0.22f}},
      {"acid violet", {0.53f, 0.40f, 0.62f}},
      {"fire red", {0.75f, 0.15f, 0.13f}},
      {"instrument steel", {0.66f, 0.69f, 0.72f}},
      {"steel grey", {0.48f, 0.50f, 0.53f}},
      {"safety yellow", {0.93f, 0.75f, 0.12f}},
      {"vessel silver", {0.83f, 0.84f, 0.86f}},
      {"vessel white", {0.92f, 0.91f, 0.88f}},
      {"pump blue", {0.18f, 0.36f, 0.62f}},
      {"concrete", {0.70f, 0.68f, 0.64f}},
  }};
  std::array<core::MaterialId, kPaintCount> ids;
  for (std::size_t i = 0; i < paints.size(); ++i)
    ids[i] = scene.add_material({paints[i].first, paints[i].second, 1.0f, std::uint32_t(i + 1)});
  return ids;
}

/// One part of the site, filled until its portion of the items is used up.
struct Area {
  AabbD box;  // z from 0 to the height it may reach
  double portion = 0.0;
  bool rack = false;
};

double site_area(std::uint64_t items) {
  return 40'000.0 * std::min(1.0, double(items) / double(kFullArea));
}
double site_height(std::uint64_t items) {
  return std::min(60.0, 8.0 + 0.26 * std::sqrt(site_area(items)));
}

/// A pipe rack down the middle, process plots in rows on either side.
std::vector<Area> lay_out(std::uint64_t items, Random& random) {
  const double area = site_area(items), height = site_height(items);
  const double length = 2.0 * std::sqrt(area), width = 0.25 * length;
  const double rack = std::clamp(0.14 * width, 3.0, 12.0), aisle = 0.02 * width;
  const double depth = 0.5 * (width - rack) - aisle;
  const int rows = std::max(1, int(std::lround(depth / 20.0)));
  const double row_depth = depth / rows;
  const int columns = std::max(1, int(std::lround(length / std::clamp(row_depth, 8.0, 20.0))));
  const double column_width = length / columns;

  const std::int64_t plots = 2 * rows * columns;
  const double per_plot = (1.0 - kRackShare) * double(items) / double(plots);
  // More pipe needs more tiers: about 350 items to a tier of a full-sized plot, 25 to a metre of a tier of the rack.
  const double plot_top = 5.0 + 3.0 * std::clamp(per_plot / 350.0, 2.0, 18.0);
  const double rack_top = 6.0 + 3.0 * std::clamp(kRackShare * double(items) / (25.0 * length), 1.0, 10.0);

  std::vector<Area> areas;
  const auto add = [&](const dvec3& low, const dvec3& high, double portion, bool is_rack) {
    areas.push_back({{low, {high.x, high.y, std::min(height, high.z)}}, portion, is_rack});
  };
  add({-0.5 * length + 0.1, -0.5 * rack, 0.0}, {0.5 * length - 0.1, 0.5 * rack, rack_top}, kRackShare, true);
  for (int column = 0; column < columns; ++column) {
    for (int row = 0; row < 2 * rows; ++row) {
      const double x = -0.5 * length + column * column_width;
      const int row_of_side = row / 2;
      const double near = 0.5 * rack + aisle + row_of_side * row_depth;
      const double y = row % 2 == 0 ? near : -near - row_depth;
      const double gap = 0.04 * row_depth;
      add({x + gap, y + gap, 0.0}, {x + column_width - gap, y + row_depth - gap, plot_top * random.between(0.65, 1.0)},
          (1.0 - kRackShare) / double(plots), false);
    }
  }
  return areas;
}

class Generator {
 public:
  Generator(const PlantOptions& config, core::Scene& scene)
      : scene_(scene),
        random_(config.seed),
        stage_(scene, config.items),
        areas_(lay_out(config.items, random_)),
        site_height_(site_height(config.items)) {}

  void run() {
    paints_ = mix_paints(scene_);
    const core::NodeId site = scene_.add_node(scene_.root(), "SITE");
    double done = 0.0;
    for (std::size_t i = 0; i < areas_.size(); ++i) {
      const Area& area = areas_[i];
      done = i + 1 == areas_.size() ? 1.0 : done + area.portion;
      stage_.allow(done);
      zone_ = scene_.add_node(site, "ZONE-" + std::string(area.rack ? "RACK" : "A" + std::to_string(i)));
      obstacles_.clear();
      area.rack ? build_rack(area) : build_plot(area, int(i));
      if (i + 1 == areas_.size()) use_up(area);
    }
  }

 private:
  void begin(const char* prefix, Paint paint) { stage_.begin(zone_, prefix, paints_[std::size_t(paint)]); }

  // --- areas ---------------------------------------------------------------------------------------------------------

  void build_rack(const Area& area) {
    Lanes lanes(pipe_space(area, 4.0), true, obstacles_);
    raise_steel(area.box, lanes.levels(), 8.0, 0.5);
    walkways(area.box, lanes.levels().back() - 0.45, kWalkway);
    fill_with_pipe(lanes);
  }

  void build_plot(const Area& area, int index) {
    Lanes lanes(pipe_space(area, 3.4), false, obstacles_);
    const dvec3 size = area.box.size();
    if (stage_.room(kOthers) >= 60) {
      begin("PAVING", kConcrete);
      add_paving(stage_, area.box.min, area.box.max);
      stage_.finish();
    }
    switch (index % 5) {
      case 0:
        place_columns(area.box);
        break;
      case 1:
        place_drums(area.box);
        break;
      case 2:
        place_tanks(area.box);
        break;
      case 3:
        place_pumps(area.box);
        break;
      default:
        place_spheres(area.box);
        break;
    }
    raise_steel(area.box, lanes.levels(), 6.5, 0.4);
    furnish(area.box, lanes.levels(), size);
    fill_with_pipe(lanes);
  }

  /// Where pipes may run, with room for what sticks out of a lane.
  static AabbD pipe_space(const Area& area, double lowest) {
    AabbD space = area.box;
    const double inset = std::min(0.6, 0.1 * std::min(space.size().x, space.size().y));
    space.min += dvec3(inset + 0.2, inset, 0.0);
    space.max -= dvec3(inset + 0.2, inset, 0.3);
    if (area.rack) space.max.y -= kWalkway;
    space.min.z = std::min(lowest, 0.4 * space.max.z);
    return space;
  }

  void fill_with_pipe(Lanes& lanes) {
    for (int idle = 0; stage_.room() > 12 && idle < 40;) {
      const Lane lane = lanes.next(random_);
      if (lane.opens_bank) service_ = Paint(random_.below(kServices));
      if (lane.length <= 0.0) continue;
      idle = lay(lane) ? 0 : idle + 1;
    }
  }

  bool lay(const Lane& lane) {
    const bool tubing = lane.radius < 0.007;
    begin(tubing ? "TUBE" : "PIPE", tubing ? kInstrument : service_);
    lay_pipe(stage_, random_, lane);
    return stage_.finish();
  }

  /// Tubing takes what is left of every share: each run uses at least one item, because something always fits.
  void use_up(const Area& area) {
    const Lanes lanes(pipe_space(area, 3.4), false, obstacles_);
    while (stage_.room() > 0) lay(lanes.tubing(random_));
  }

  // --- steel ---------------------------------------------------------------------------------------------------------

  /// Builds the finest frame that leaves enough boxes for other things, if any frame does.
  void raise_steel(const AabbD& box, const std::vector<double>& levels, double bay, double share) {
    const double most = share * double(stage_.room(kOthers));
    for (std::size_t used = levels.size(); used > 0; --used) {
      for (double pitch = bay; pitch < 4.0 * bay; pitch *= 1.5) {
        const auto bays = [&](double length) { return std::max(1, int(std::lround(length / pitch))); };
        const SteelGrid grid{box, bays(box.size().x), bays(box.size().y)};
        if (double(steel_frame_cost(grid, used)) > most) continue;
        std::vector<double> tops(levels.begin(), levels.begin() + std::ptrdiff_t(used));
        for (double& z : tops) z -= 0.5;  // pipes rest above on shoes
        begin("STRUCTURE", kSteelGrey);
        add_steel_frame(stage_, grid, tops);
        if (stage_.finish()) return;
      }
    }
  }

  /// Builds a gangway along the whole rack, in stretches.
  void walkways(const AabbD& box, double z, double width) {
    for (double x = box.min.x; x + 10.0 <= box.max.x; x += 12.0) {
      if (stage_.room(kOthers) < 40) return;
      platform({x, box.max.y - width - 0.1, z}, {x + 10.0, box.max.y - 0.1, z});
    }
  }

  void platform(const dvec3& low, const dvec3& high) {
    begin("PLATFORM", kSafetyYellow);
    add_platform(stage_, low, high);
    stage_.finish();
  }

  /// Adds platforms, stairs, trays and ducts on the levels of a plot, as long as half of the plot's boxes are left for
  /// pipe shoes.
  void furnish(const AabbD& box, const std::vector<double>& levels, const dvec3& size) {
    const std::int64_t keep = stage_.room(kOthers) / 2;
    const double reach = std::min(size.x, size.y);
    if (reach < 3.0) return;
    for (std::size_t tries = 0; tries < 12 * levels.size() && stage_.room(kOthers) > keep; ++tries) {
      const double z = levels[tries % levels.size()] - 0.45;
      const double length = random_.between(0.3, 0.6) * size.x, x = box.min.x + (size.x - length) * random_.unit();
      const double y = box.min.y + 0.1 * size.y + 0.75 * size.y * random_.unit();
      switch (tries % 4) {
        case 0:
          platform({x, y, z}, {x + length, std::min(box.max.y, y + 1.6), z});
          break;
        case 1:
          stairs(box, size, z);
          break;
        case 2:
          begin("TRAY", kVesselSilver);
          add_cable_tray(stage_, {x, y, z + 1.6}, {1, 0, 0}, length);
          stage_.finish();
          break;
        default:
          begin("DUCT", kVesselSilver);
          add_duct(stage_, {x, y - 0.1 * size.y, z + 2.0}, length, std::min(0.6, 0.04 * reach));
          stage_.finish();
      }
    }
  }

  void stairs(const AabbD& box, const dvec3& size, double top) {
    const double rise = std::min(3.0, top), run = rise * 4.0 / 3.0;
    if (run + 1.0 > size.x) return;
    const double sign = random_.chance(0.5) ? 1.0 : -1.0;
    const double foot = sign > 0.0 ? box.min.x + 0.4 : box.min.x + 0.4 + run;
    begin("STAIR", kSafetyYellow);
    add_stairs(stage_, {foot, box.max.y - 0.6, top - rise}, sign, 0.8, rise);
    stage_.finish();
  }

  // --- equipment -----------------------------------------------------------------------------------------------------

  /// `count` places in a row along x through the plot at a fraction of its depth.
  static dvec3 place_in_row(const AabbD& box, int i, int count, double depth) {
    return {box.min.x + (i + 0.5) / count * box.size().x, box.min.y + depth * box.size().y, 0.0};
  }

  /// Whether boxes and dishes are left for more equipment. It may use most of the area's, never all.
  bool affordable() const { return stage_.room(kOthers) >= 10; }

  void keep_clear(const dvec3& foot, const dvec3& half, double height) {
    obstacles_.push_back({foot - half, foot + dvec3(half.x, half.y, height)});
  }

  void place_columns(const AabbD& box) {
    const double reach = std::min(box.size().x, box.size().y);
    const int count = reach > 14.0 ? 3 : reach > 5.0 ? 2 : 1;
    for (int i = 0; i < count && affordable(); ++i) {
      const double radius = std::min(2.5, 0.1 * reach) * random_.between(0.5, 1.0);
      const double height = std::min(site_height_ - 1.5, radius * random_.between(12.0, 25.0));
      const dvec3 foot = place_in_row(box, i, count, 0.5);
      begin("COLUMN", random_.chance(0.5) ? kVesselSilver : kVesselWhite);
      add_column(stage_, random_, foot, radius, height);
      if (stage_.finish()) keep_clear(foot, dvec3(radius + 1.2, radius + 1.2, 0.0), height);
    }
  }

  void place_drums(const AabbD& box) {
    const double reach = std::min(box.size().x, box.size().y);
    for (int i = 0; i < 4 && affordable(); ++i) {
      const double radius = std::min(1.6, 0.09 * reach) * random_.between(0.4, 1.0);
      const double length = std::min(0.38 * box.size().x, radius * random_.between(4.0, 7.0));
      const dvec3 foot = place_in_row(box, i % 2, 2, i < 2 ? 0.25 : 0.7);
      begin("DRUM", random_.chance(0.7) ? kVesselSilver : kVesselWhite);
      add_drum(stage_, random_, foot, radius, length);
      if (stage_.finish()) keep_clear(foot, {0.5 * length + radius, radius, 0.0}, 2.0 * radius + 1.4);
    }
  }

  void place_tanks(const AabbD& box) {
    const double reach = std::min(box.size().x, box.size().y);
    for (int i = 0; i < 4 && affordable(); ++i) {
      const double radius = std::min(4.0, 0.2 * reach) * (i == 0 ? 1.0 : random_.between(0.6, 1.0));
      const double height = std::min(site_height_ - 2.0, radius * random_.between(1.4, 3.0));
      const dvec3 foot = place_in_row(box, i % 2, 2, i < 2 ? 0.25 : 0.75);
      begin("TANK", kVesselWhite);
      add_tank(stage_, random_, foot, radius, height);
      if (stage_.finish()) keep_clear(foot, dvec3(radius + 0.3, radius + 0.3, 0.0), height);
    }
  }

  void place_pumps(const AabbD& box) {
    const double reach = std::min(box.size().x, box.size().y), size = std::clamp(0.06 * reach, 0.25, 1.1);
    for (int i = 0; i < 8 && affordable(); ++i) {
      const dvec3 foot = place_in_row(box, i % 4, 4, i < 4 ? 0.2 : 0.8);
      begin("PUMP", kPumpBlue);
      add_pump(stage_, foot, size * random_.between(0.7, 1.0));
      if (stage_.finish()) keep_clear(foot, {1.2 * size, 0.5 * size, 0.0}, 1.8 * size);
    }
    if (!affordable()) return;
    begin("HOPPER", kVesselSilver);
    add_hopper(stage_, place_in_row(box, 0, 1, 0.5), std::min(2.0, 0.15 * reach));
    stage_.finish();
  }

  void place_spheres(const AabbD& box) {
    const double reach = std::min(box.size().x, box.size().y);
    for (int i = 0; i < 2 && affordable(); ++i) {
      const double radius = std::min({4.0, 0.22 * reach, 0.35 * site_height_}) * random_.between(0.7, 1.0);
      const dvec3 foot = place_in_row(box, i, 2, 0.5);
      begin("SPHERE", kVesselWhite);
      add_sphere_tank(stage_, foot, radius);
      if (stage_.finish()) keep_clear(foot, dvec3(1.05 * radius, 1.05 * radius, 0.0), 2.6 * radius);
    }
  }

  core::Scene& scene_;
  Random random_;
  Stage stage_;
  std::vector<Area> areas_;
  double site_height_;
  std::vector<AabbD> obstacles_;
  std::array<core::MaterialId, kPaintCount> paints_;
  core::NodeId zone_;
  Paint service_ = kWater;
};

}  // namespace

core::Expected<void> generate_plant(const PlantOptions& config, core::Scene& scene) {
  if (config.items < kFewest || config.items > kMost)
    return core::fail("plant generator: expected 1000 to 10000000 items, got " + std::to_string(config.items));
  Generator(config, scene).run();
  return {};
}

}  // namespace sightline::importers
