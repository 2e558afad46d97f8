#include "sightline/apps/bench/models/aircraft.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "sightline/apps/bench/models/random.h"

namespace sightline::bench {
namespace {

using core::dvec3;

constexpr double kLength = 63.0, kRadius = 3.1, kWingSpan = 30.0;

class Aircraft {
 public:
  Aircraft(std::size_t count, std::uint64_t seed) : count_(count), random_(seed) { boxes_.reserve(count); }

  std::vector<core::Aabb> run() {
    // Shares of the parts; what rounding leaves over becomes fasteners.
    fill(0.06, [&] { fuselage_panel(); });
    fill(0.05, [&] { frame_segment(); });
    fill(0.06, [&] { stringer(); });
    fill(0.16, [&] { wing_part(); });
    fill(0.12, [&] { cabin_part(); });
    fill(0.23, [&] { system_part(); });
    fill(0.14, [&] { engine_part(); });
    while (boxes_.size() < count_) fastener();
    return std::move(boxes_);
  }

 private:
  template <class Make>
  void fill(double share, const Make& make) {
    const std::size_t until = std::min(count_, boxes_.size() + std::size_t(share * double(count_)));
    while (boxes_.size() < until) make();
  }
  void add(const dvec3& centre, const dvec3& size) {
    boxes_.push_back(core::round_outwards({centre - 0.5 * size, centre + 0.5 * size}, dvec3(0.0)));
  }

  /// Nose and tail taper.
  static double radius_at(double x) {
    const double nose = std::clamp((kLength / 2 - x) / 7.0, 0.02, 1.0);
    const double tail = std::clamp((x + kLength / 2) / 16.0, 0.05, 1.0);
    return kRadius * std::sqrt(nose) * tail;
  }
  static dvec3 on_shell(double x, double angle, double factor) {
    const double r = radius_at(x) * factor;
    return {x, r * std::cos(angle), r * std::sin(angle)};
  }
  double station() { return random_.between(-kLength / 2, kLength / 2); }
  double angle() { return random_.between(0.0, 2.0 * std::numbers::pi); }

  /// Bounding box of a piece of shell `arc` wide and `length` long.
  void shell(double x, double from, double arc, double length, double thickness, double factor) {
    core::AabbD box;
    for (int i = 0; i <= 4; ++i) {
      const dvec3 p = on_shell(x, from + arc * i / 4.0, factor);
      box.grow(p + dvec3(0.5 * length, thickness, thickness));
      box.grow(p - dvec3(0.5 * length, thickness, thickness));
    }
    boxes_.push_back(core::round_outwards(box, dvec3(0.0)));
  }
  void fuselage_panel() { shell(station(), angle(), random_.between(0.05, 0.4), random_.size(0.3, 4.0), 0.004, 1.0); }
  void frame_segment() {
    const double x = std::round(station() / 0.53) * 0.53;
    shell(x, angle(), random_.between(0.1, 0.6), 0.08, 0.05, 0.97);
  }
  void stringer() {
    const double a = std::round(angle() * 20.0) / 20.0;
    shell(station(), a, 0.01, random_.size(1.0, 9.0), 0.015, 0.985);
  }
  void wing_part() {
    const double side = random_.chance(0.5) ? 1.0 : -1.0, t = random_.unit();
    const double y = kRadius + t * (kWingSpan - kRadius), chord = 10.0 - 8.0 * t, sweep = -0.55 * (y - kRadius);
    const dvec3 at{4.0 + sweep - random_.unit() * chord, side * y, -1.2 + 0.1 * (y - kRadius)};
    const double height = 0.12 * chord * random_.between(-0.5, 0.5);
    switch (int(random_.between(0.0, 4.0))) {
      case 0:  // skin
        add(at + dvec3(0, 0, height > 0 ? 0.06 * chord : -0.06 * chord),
            {random_.size(0.3, 2.0), random_.size(0.3, 3.0), 0.02});
        break;
      case 1:  // rib
        add(at, {0.6 * chord * random_.unit() + 0.1, 0.03, 0.1 * chord});
        break;
      case 2:  // lines along the span
        add(at + dvec3(0, 0, height), {0.04, random_.size(0.5, 6.0), 0.04});
        break;
      default:
        add(at + dvec3(0, 0, height), dvec3(random_.size(0.01, 0.2), random_.size(0.01, 0.2), random_.size(0.01, 0.1)));
    }
  }
  void cabin_part() {
    const double row = std::round(random_.between(-22.0, 22.0) / 0.81) * 0.81;
    const double seat = std::round(random_.between(-4.5, 4.5)) * 0.58;
    switch (int(random_.between(0.0, 3.0))) {
      case 0:  // parts of a seat
        add({row + random_.between(-0.3, 0.3), seat + random_.between(-0.2, 0.2), random_.between(-0.2, 0.9)},
            {random_.size(0.02, 0.5), random_.size(0.02, 0.5), random_.size(0.02, 0.6)});
        break;
      case 1:  // bins and linings
        add({row, (seat > 0 ? 1.0 : -1.0) * random_.between(0.6, 2.4), random_.between(1.5, 2.1)},
            {random_.size(0.1, 2.5), random_.size(0.1, 0.7), random_.size(0.05, 0.5)});
        break;
      default:  // floor beams and panels
        add({row, seat, random_.between(-0.55, -0.4)},
            random_.chance(0.5) ? dvec3(0.06, random_.size(0.5, 5.0), 0.12) : dvec3(random_.size(0.3, 2.0), 0.5, 0.02));
    }
  }
  void system_part() {
    const double x = station();
    const dvec3 at = on_shell(x, angle(), random_.chance(0.7) ? random_.between(0.88, 0.96) : random_.unit());
    if (random_.chance(0.25)) {  // harness, duct, pipe
      add(at, {random_.size(0.4, 8.0), random_.size(0.01, 0.2), random_.size(0.01, 0.2)});
    } else if (random_.chance(0.2)) {
      add(at, {random_.size(0.01, 0.1), random_.size(0.2, 3.0), random_.size(0.01, 0.1)});
    } else {
      add(at, {random_.size(0.008, 0.25), random_.size(0.008, 0.25), random_.size(0.008, 0.25)});
    }
  }
  void engine_part() {
    const double side = random_.chance(0.5) ? 1.0 : -1.0, r = 1.7 * std::sqrt(random_.unit()), a = angle();
    const dvec3 at{random_.between(0.0, 5.5), side * 9.6 + r * std::cos(a), -2.4 + r * std::sin(a)};
    add(at, {random_.size(0.005, 0.3), random_.size(0.005, 0.15), random_.size(0.005, 0.15)});
  }
  void fastener() {
    dvec3 at = on_shell(station(), angle(), random_.between(0.94, 1.0));
    if (random_.chance(0.3)) {
      const double y = random_.between(-kWingSpan, kWingSpan), t = std::abs(y) / kWingSpan;
      at = {4.0 - 0.55 * std::abs(y) - random_.unit() * (10.0 - 8.0 * t), y, -1.2 + 0.1 * std::abs(y)};
    }
    add(at, {random_.size(0.003, 0.03), random_.size(0.003, 0.03), random_.size(0.003, 0.03)});
  }

  std::size_t count_;
  Random random_;
  std::vector<core::Aabb> boxes_;
};

}  // namespace

std::vector<core::Aabb> make_aircraft(std::size_t count, std::uint64_t seed) {
  return Aircraft(count, seed).run();
}

}  // namespace sightline::bench
