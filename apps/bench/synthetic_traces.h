// Made-up controller traces: each a difficulty of its own, the same in the benchmark, the tests and on every machine.
#pragma once

#include <cmath>
#include <cstdint>
#include <numbers>
#include <string>
#include <utility>
#include <vector>

#include "sightline/apps/common/controller_trace.h"

namespace sightline::bench {

enum class TraceClass : std::uint8_t { kStationary, kChanging };

struct SyntheticTrace {
  std::string name;
  TraceClass kind;
  std::vector<apps::TraceFrame> frames;
};

/// Uniform in [0, 1), the same everywhere (std distributions differ between libraries).
class TraceRandom {
 public:
  explicit TraceRandom(std::uint64_t seed) : state_(seed * 0x9e3779b97f4a7c15u + 1) {}
  double next() {  // xorshift64*
    state_ ^= state_ >> 12;
    state_ ^= state_ << 25;
    state_ ^= state_ >> 27;
    return double((state_ * 0x2545f4914f6cdd1du) >> 11) * 0x1p-53;
  }
  /// 1 + amplitude * [-1, 1).
  double around_one(double amplitude) { return 1.0 + amplitude * (2.0 * next() - 1.0); }

 private:
  std::uint64_t state_;
};

/// `cost(i)` gives {cpu, gpu, visible} of frame i. Cull and frame times are the same, so a trace says the same with
/// rendering on and off.
template <class Cost>
std::vector<apps::TraceFrame> make_trace(std::size_t frames, double noise, std::uint64_t seed, const Cost& cost) {
  TraceRandom random(seed);
  std::vector<apps::TraceFrame> trace;
  for (std::size_t i = 0; i < frames; ++i) {
    const auto [cpu, gpu, visible] = cost(i);
    const double c = cpu * random.around_one(noise), g = gpu * random.around_one(noise);
    trace.push_back({.cpu_cull_ms = c, .cpu_frame_ms = c, .gpu_cull_ms = g, .gpu_frame_ms = g, .visible = visible});
  }
  return trace;
}

struct TraceCost {
  double cpu, gpu, visible;
};

/// Every second one of `period` frames long stretches.
inline bool second_half(std::size_t i, std::size_t period) {
  return i / period % 2 == 1;
}

/// Traces, each of so many frames and with random numbers of its own.
struct SyntheticTraces {
  std::uint64_t seed;
  std::size_t frames;
  std::vector<SyntheticTrace> all = {};

  template <class Cost>
  void add(const std::string& name, TraceClass kind, double noise, const Cost& cost) {
    all.push_back({name, kind, make_trace(frames, noise, seed + 1000 * all.size(), cost)});
  }
};

inline void add_stationary(SyntheticTraces& traces) {
  const auto stationary = [&](const std::string& name, double noise, double cpu, double gpu) {
    traces.add(name, TraceClass::kStationary, noise, [=](std::size_t) { return TraceCost{cpu, gpu, 1e5}; });
  };
  stationary("constant, CPU 1 GPU 2", 0.0, 1.0, 2.0);
  stationary("constant, CPU 2 GPU 1", 0.0, 2.0, 1.0);
  stationary("noise 30 %, CPU 1 GPU 5", 0.3, 1.0, 5.0);
  stationary("noise 30 %, CPU 1 GPU 1.3", 0.3, 1.0, 1.3);
  stationary("noise 30 %, CPU 1 GPU 1.03", 0.3, 1.0, 1.03);
  stationary("noise 30 %, CPU 1 GPU 1", 0.3, 1.0, 1.0);
  stationary("noise 30 %, CPU 1.03 GPU 1", 0.3, 1.03, 1.0);
  stationary("noise 30 %, CPU 1.3 GPU 1", 0.3, 1.3, 1.0);
  stationary("noise 30 %, CPU 5 GPU 1", 0.3, 5.0, 1.0);
  {
    TraceRandom random(traces.seed + 77);
    traces.add("spikes x20 in 3 %, CPU 1 GPU 1.5", TraceClass::kStationary, 0.05, [&](std::size_t) {
      const double spike = random.next() < 0.03 ? 20.0 : 1.0;
      return TraceCost{spike, 1.5 * spike, 1e5};
    });
    traces.add("spikes x20 in 3 %, CPU 1.5 GPU 1", TraceClass::kStationary, 0.05, [&](std::size_t) {
      const double spike = random.next() < 0.03 ? 20.0 : 1.0;
      return TraceCost{1.5 * spike, spike, 1e5};
    });
  }
}

inline void add_changing(SyntheticTraces& traces) {
  const std::size_t frames = traces.frames;
  const auto changing = [&](const std::string& name, double noise, const auto& cost) {
    traces.add(name, TraceClass::kChanging, noise, cost);
  };
  changing("step, CPU 1 to 6, GPU 2", 0.1, [=](std::size_t i) {
    return TraceCost{2 * i < frames ? 1.0 : 6.0, 2.0, 1e5};
  });
  changing("step, CPU 6 to 1, GPU 2", 0.1, [=](std::size_t i) {
    return TraceCost{2 * i < frames ? 6.0 : 1.0, 2.0, 1e5};
  });
  changing("step, both swap 1 and 4", 0.1, [=](std::size_t i) {
    const bool late = 2 * i >= frames;
    return TraceCost{late ? 4.0 : 1.0, late ? 1.0 : 4.0, 1e5};
  });
  changing("steps of the view every 200", 0.1, [](std::size_t i) {
    const double visible = second_half(i, 200) ? 4e5 : 2e4;
    return TraceCost{0.2 + 1e-5 * visible, 1.0, visible};
  });
  const auto wave = [=](std::size_t i, double periods) {
    return 0.5 - 0.5 * std::cos(2.0 * std::numbers::pi * periods * double(i) / double(frames));
  };
  changing("ramps of the view", 0.0, [=](std::size_t i) {
    const double visible = 1e3 + 5e5 * wave(i, 3.0);
    return TraceCost{0.1 + 1e-5 * visible, 1.0 + 1e-6 * visible, visible};
  });
  changing("ramps of the view, noise 30 %", 0.3, [=](std::size_t i) {
    const double visible = 1e3 + 5e5 * wave(i, 3.0);
    return TraceCost{0.1 + 1e-5 * visible, 1.0 + 1e-6 * visible, visible};
  });
  changing("ramps unexplained by the view", 0.05, [=](std::size_t i) {
    return TraceCost{0.5 + 3.0 * wave(i, 2.0), 1.5, 1e5};
  });
  changing("alternating every 10, by the view", 0.05, [](std::size_t i) {
    const double visible = second_half(i, 10) ? 4e5 : 2e4;
    return TraceCost{second_half(i, 10) ? 5.0 : 0.5, 1.5, visible};
  });
}

inline void add_adversarial(SyntheticTraces& traces) {
  const auto changing = [&](const std::string& name, double noise, const auto& cost) {
    traces.add(name, TraceClass::kChanging, noise, cost);
  };
  for (const double ratio : {2.0, 5.0, 10.0})
    changing("alternating every 10, unexplained, 1:" + std::to_string(int(ratio)), 0.05, [=](std::size_t i) {
      const bool second = second_half(i, 10);
      return TraceCost{second ? ratio : 1.0, second ? 1.0 : ratio, 1e5};
    });
  for (const std::size_t period : {std::size_t(4), std::size_t(7)})
    changing("adversarial: swapping 1:3 every " + std::to_string(period), 0.0, [=](std::size_t i) {
      const bool second = second_half(i, period);
      return TraceCost{second ? 3.0 : 1.0, second ? 1.0 : 3.0, 1e5};
    });
  {
    TraceRandom random(traces.seed + 99);
    bool second = false;
    changing("adversarial: swapping 1:5 at random", 0.1, [&](std::size_t) {
      if (random.next() < 1.0 / 15.0) second = !second;
      return TraceCost{second ? 5.0 : 1.0, second ? 1.0 : 5.0, 1e5};
    });
  }
  changing("adversarial: the view lies", 0.1, [](std::size_t i) {  // visible swings, costs do not follow
    return TraceCost{second_half(i, 100) ? 1.0 : 3.0, second_half(i, 100) ? 3.0 : 1.0, i % 2 ? 1e6 : 10.0};
  });
}

inline std::vector<SyntheticTrace> synthetic_traces(std::uint64_t seed = 1, std::size_t frames = 2000) {
  SyntheticTraces traces{seed, frames};
  add_stationary(traces);
  add_changing(traces);
  add_adversarial(traces);
  return std::move(traces.all);
}

}  // namespace sightline::bench
