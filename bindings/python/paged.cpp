// Engines of scenes that are larger than memory.
#include <algorithm>
#include <cmath>
#include <memory>
#include <optional>

#include "sightline/bindings/python/config.h"
#include "sightline/bindings/python/images.h"
#include "sightline/bindings/python/module.h"
#include "sightline/bindings/python/progress.h"
#include "sightline/bindings/python/scene.h"
#include "sightline/bindings/python/values.h"
#include "sightline/core/internal/store.h"
#include "sightline/importers/slc/paged_scene.h"

namespace sightline::python {
namespace {

using engine::PagedConfig;
using engine::PagedEngine;
using engine::PagedReport;

/// After close() all calls fail.
class PagedEngineBox {
 public:
  PagedEngineBox(const std::filesystem::path& path, const PagedConfig& config, const py::object& progress)
      : config_(config) {
    Progress told(progress);
    core::Expected<void> done;
    {
      const LongCall use({gate_, Use::kWrite});
      auto made = importers::open_paged_scene(path, told.function()).and_then([&](core::PagedScene scene) {
        return PagedEngine::create(std::move(scene), config);
      });
      done = core::store(std::move(made), engine_);
    }
    told.rethrow();
    unwrap(std::move(done));
  }

  const PagedConfig& config() const { return config_; }
  void close() {
    const LongCall use({gate_, Use::kWrite});
    engine_.reset();
  }
  bool closed() {
    gate_.pass(Use::kRead);
    return !engine_;
  }

  /// What `work` returns for the engine, called without the GIL.
  template <class Work>
  auto call(const Work& work) {
    const LongCall use({gate_, Use::kWrite});
    if (!engine_) fail("engine: it is closed");
    return work(*engine_);
  }

  PagedReport frame(const core::View& view) {
    PagedReport report = unwrap(call([&](PagedEngine& e) { return e.frame(view); }));
    drawn_ = true;
    return report;
  }

  PagedReport settle(const core::View& view, const py::object& progress) {
    Progress told(progress);
    auto report = call([&, step = told.function()](PagedEngine& e) {
      return e.settle(view, [&](const PagedReport& r) {
        return step(1.0 - double(r.pending) / double(std::max<std::int64_t>(1, r.leaves)));
      });
    });
    told.rethrow();
    drawn_ = true;
    return unwrap(std::move(report));
  }

  /// What `work` reads of the last frame's image.
  template <class Work>
  auto read(const Work& work) {
    return to_array(call([&](PagedEngine& e) {
      if (!drawn_) fail("image: nothing is drawn before the first frame");
      return work(e);
    }));
  }

 private:
  PagedConfig config_;
  Gate gate_;
  bool drawn_ = false;
  std::optional<PagedEngine> engine_;
};

using PagedEngineClass = py::class_<PagedEngineBox>;

void bind_paged_report(py::module_& m) {
  py::class_<PagedReport> c(m, "PagedReport", "What a frame of a PagedEngine shows, and what it lacks.");
  c.def_readonly("frame", &PagedReport::frame, "Frames before this one.")
      .def_readonly("frame_ms", &PagedReport::frame_ms, "Milliseconds of wall clock, until all was drawn.")
      .def_readonly("leaves", &PagedReport::leaves, "Leaves in the view volume that may cover a sample.")
      .def_readonly("pending", &PagedReport::pending, "Of these, not drawn and not known to be hidden.")
      .def_readonly("coarseness", &PagedReport::coarseness, "As in FrameReport, of an image traced within budget_ms.")
      .def_readonly("earlier", &PagedReport::earlier, "Likewise.")
      .def_readonly("placeholders", &PagedReport::placeholders, "Splats drawn for them.")
      .def_readonly("coarse_items", &PagedReport::coarse_items, "Items drawn for them by their coarsest levels.")
      .def_readonly("items_drawn", &PagedReport::items_drawn, "Items drawn into the image so far.")
      .def_readonly("complete", &PagedReport::complete, "Whether nothing is missing that can be read.")
      .def_readonly("resident", &PagedReport::resident, "Pages in memory.")
      .def_readonly("loaded", &PagedReport::loaded, "Pages read since the start.")
      .def_readonly("evicted", &PagedReport::evicted, "Pages given up since the start.")
      .def_readonly("prefetched", &PagedReport::prefetched, "Of those read, pages that no image needed yet.")
      .def_readonly("failed", &PagedReport::failed, "Pages that cannot be read: take_errors().")
      .def_readonly("coarse_resident", &PagedReport::coarse_resident, "Pages of coarsest levels in memory.")
      .def_readonly("coarse_loaded", &PagedReport::coarse_loaded, "Those read since the start.")
      .def_readonly("memory", &PagedReport::memory, "Bytes of the process; 0 where the system does not say.")
      .def("__repr__", [](const PagedReport& r) {
        return "<sightline.PagedReport " + std::to_string(r.frame) + ": " + std::to_string(r.pending) + " of " +
               std::to_string(r.leaves) + " leaves pending>";
      });
  bind_value<&PagedReport::frame, &PagedReport::frame_ms, &PagedReport::leaves, &PagedReport::pending,
             &PagedReport::placeholders, &PagedReport::coarse_items, &PagedReport::items_drawn, &PagedReport::complete,
             &PagedReport::resident, &PagedReport::loaded, &PagedReport::evicted, &PagedReport::prefetched,
             &PagedReport::failed, &PagedReport::coarse_resident, &PagedReport::coarse_loaded, &PagedReport::memory,
             &PagedReport::coarseness, &PagedReport::earlier>(c);
}

std::unique_ptr<PagedEngineBox> open_pages(const std::filesystem::path& path, const py::object& progress,
                                           const py::kwargs& given) {
  return std::make_unique<PagedEngineBox>(path, config_of<PagedConfig>("PagedEngine", given), progress);
}

void bind_paged_settings(PagedEngineClass& c) {
  using namespace py::literals;
  const std::string doc = doc_of<PagedConfig>(
      "__init__", "path: object", "progress: object = None",
      "Opens a scene cache, or all of a folder as parts of one scene.\n\n"
      "progress: called with the share that is opened, 0 to 1; False cancels, and so do exceptions and Ctrl-C.");
  py::options options;
  options.disable_function_signatures();
  c.def(py::init(&open_pages), "path"_a, py::kw_only(), "progress"_a = py::none(), doc.c_str());
}

void bind_paged_life(PagedEngineClass& c) {
  c.def("close", &PagedEngineBox::close, "Frees everything now. Later calls fail; a second close() does nothing.")
      .def_property_readonly("closed", &PagedEngineBox::closed, "Whether close() has been called.")
      .def("__enter__", [](const py::object& self) { return self; })
      .def("__exit__", [](PagedEngineBox& b, const py::args&) { b.close(); });
}

void bind_paged_frames(PagedEngineClass& c) {
  using namespace py::literals;
  c.def(
       "frame",
       [](PagedEngineBox& b, const core::View& view) {
         const core::View drawn = view;
         return b.frame(drawn);
       },
       "view"_a,
       "Draws what is in memory of the view, and asks for what is not. The same view again goes on with the image.")
      .def(
          "settle",
          [](PagedEngineBox& b, const core::View& view, const py::object& progress) {
            const core::View drawn = view;
            return b.settle(drawn, progress);
          },
          "view"_a, py::kw_only(), "progress"_a = py::none(),
          "Draws until the image is complete. `progress`: called now and then with the share of the view's leaves that "
          "are drawn; where it returns False, the image stays as it is. Exceptions and Ctrl-C stop it, too.")
      .def(
          "wait",
          [](PagedEngineBox& b, double seconds) {
            if (std::isnan(seconds)) fail("seconds: expected a number, found nan");
            return b.call([&](PagedEngine& e) { return e.wait(seconds); });
          },
          "seconds"_a,
          "Waits until a page has arrived for the next frame, at most so long. False, at once, where none is on its "
          "way.")
      .def(
          "read_colour", [](PagedEngineBox& b) { return b.read([](PagedEngine& e) { return e.read_colour(); }); },
          "The last frame's image, (height, width, 3) uint8, rows from the top. The array owns it.")
      .def(
          "read_ids",
          [](PagedEngineBox& b) {
            if (!b.config().drawing.ids) fail("image: ids are not drawn without `ids`");
            return b.read([](PagedEngine& e) { return e.read_ids(); });
          },
          "Item + 1 of each pixel, (height, width) uint32; 0: background. Needs `ids`. The array owns it.")
      .def(
          "read_depth", [](PagedEngineBox& b) { return b.read([](PagedEngine& e) { return e.read_depth(); }); },
          "Metres along the axis of the drawn view, (height, width) float32; infinite where nothing is, and where "
          "splats "
          "are. The array owns it.");
}

void bind_paged_state(PagedEngineClass& c) {
  c.def_property_readonly(
       "items", [](PagedEngineBox& b) { return b.call([](PagedEngine& e) { return e.scene().items; }); },
       "Number of items of the scene.")
      .def_property_readonly(
          "pages", [](PagedEngineBox& b) { return b.call([](PagedEngine& e) { return e.scene().pages.size(); }); },
          "Number of pages of the scene.")
      .def_property_readonly(
          "bounds",
          [](PagedEngineBox& b) { return to_array(b.call([](PagedEngine& e) { return e.scene().fitted.bounds; })); },
          "[[min], [max]] of all items, without those that lie too far from all others; None: there are none.")
      .def_property_readonly(
          "page_bytes", [](PagedEngineBox& b) { return b.call([](PagedEngine& e) { return e.memory().pages; }); },
          "Bytes of pages in memory and on their way.")
      .def_property_readonly(
          "page_limit", [](PagedEngineBox& b) { return b.call([](PagedEngine& e) { return e.memory().limit; }); },
          "Bytes that these may come to.")
      .def_property_readonly(
          "renderer", [](PagedEngineBox& b) { return b.call([](PagedEngine& e) { return e.renderer(); }); },
          "As GL names it.")
      .def(
          "take_errors", [](PagedEngineBox& b) { return b.call([](PagedEngine& e) { return e.take_errors(); }); },
          "Why pages could not be read, each once.")
      .def(
          "take_gl_errors", [](PagedEngineBox& b) { return b.call([](PagedEngine& e) { return e.take_gl_errors(); }); },
          "What the driver has complained of since the last call: see `gl_debug`.")
      .def_property_readonly(
          "width", [](const PagedEngineBox& b) { return b.config().width; }, "Of the image, in pixels.")
      .def_property_readonly(
          "height", [](const PagedEngineBox& b) { return b.config().height; }, "Of the image, in pixels.");
}

}  // namespace

void bind_paged(py::module_& m) {
  bind_paged_report(m);
  PagedEngineClass c(m, "PagedEngine",
                     "Draws scenes that are larger than memory, within a limit. Calls release the GIL; of several "
                     "threads that call one engine, one runs at a time. Usable in a with statement.");
  bind_paged_settings(c);
  bind_paged_life(c);
  bind_paged_frames(c);
  bind_paged_state(c);
}

}  // namespace sightline::python
