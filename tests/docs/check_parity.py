#!/usr/bin/env python3
"""Checks that C and Python have what engines have in C++: check_parity.py ROOT [TABLE].

- Each field of the reports of engines, and each public function of Engine, PagedEngine, BoxCuller and OccluderRaster has
  a name in C and in Python: by RULES, or one that EXCEPTIONS has, or a dash there, and says why.
- Each setting of engines and imports is in its settings.inc, from which C and Python have theirs (cmake/settings.py).
- The table of settings in docs/reference/options.md is theirs.

Names in C: `function`, `struct`, `struct.field`, `CONSTANT`. In Python: `function`, `Class`, `Class.member`, and with
arguments `function(argument)`, `Class(argument)`, `Class.method(argument)`. TABLE: a page of all names is written there.
"""
import ast
import pathlib
import re
import sys

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[2] / "cmake"))
import settings  # noqa: E402

# Names in C and Python of all members, "{}" being the member's.
RULES = {
    "engine/engine.h": {
        "PixelRectangle": ("sl_engine_items_in", "Engine.items_in(rectangle)"),
        "FrameReport": ("sl_frame_report.{}", "FrameReport.{}"),
        "LateReport": ("sl_late_report.{}", "LateReport.{}"),
        "LossReport": ("sl_loss_report.{}", "LossReport.{}"),
        "MemoryReport": ("sl_engine_info.{}_bytes", "MemoryReport.{}"),
        "Engine": ("sl_engine_{}", "Engine.{}"),
    },
    "engine/plan.h": {
        "PlanEntry": ("sl_engine_explain", "PlanEntry.{}"),
        "Plan": ("sl_engine_explain", "Engine.plan"),
    },
    "engine/item_style.h": {"ItemStyle": ("sl_item_style.{}", "Engine.set_override({})")},
    "engine/pick.h": {"Pick": ("sl_pick.{}", "Pick.{}")},
    "core/ray.h": {"Ray": ("sl_ray.{}", "Engine.pick_ray({})")},
    "raytrace/tracer.h": {
        "Hit": ("sl_pick.{}", "Pick.{}"),
        "RayFilter": ("sl_ray.{}", "Engine.pick_ray({})"),
    },
    "raytrace/exact_visibility.h": {"VisibleItem": ("sl_visible_item.{}", "Engine.visible_items_in")},
    "engine/paged/paged_engine.h": {
        "PagedReport": ("sl_paged_report.{}", "PagedReport.{}"),
        "PagedEngine": ("sl_paged_engine_{}", "PagedEngine.{}"),
    },
    "engine/image_tiles.h": {
        "ImageTile": ("sl_image_tile.{}", "ImageTile.{}"),
        "CroppedTile": ("sl_cropped_tile.{}", "CroppedTile.{}"),
        "ImageTiles": ("sl_image_tiles", "ImageTiles.{}"),
    },
    "culling/cull_states.h": {
        "CullBox": ("sl_cull_box.{}", "CullStates.box_{}"),
        "CullStates": ("sl_cull_states.{}", "CullStates.{}"),
    },
    "culling/box_culler.h": {
        "BoxHit": ("sl_box_hit.{}", "BoxCuller.along"),
        "BoxCuller": ("sl_box_culler_{}", "BoxCuller.{}"),
    },
    "culling/occlusion/occluder_raster.h": {"OccluderRaster": ("sl_occluder_raster_{}", "OccluderRaster.{}")},
    "gl/external_target.h": {"ExternalTarget": ("sl_external_target.{}", "ExternalTarget.{}")},
}
SLOTS = "slots are for renderers and other tests in C++"
# Names in C, in Python, and why they are other ones; "-": there are none.
EXCEPTIONS = {
    "Engine::create": ("sl_engine_create sl_engine_config.progress", "Engine Engine(progress)", ""),
    "Engine::frame": ("sl_engine_frame sl_engine_frame_into sl_engine_frame_views",
                      "Engine.frame Engine.frame_into Engine.frame_views", ""),
    "Engine::take_late_report": ("sl_engine_late_report", "Engine.take_late_report", ""),
    "Engine::commit": ("sl_engine_commit sl_engine_commit_for", "Engine.commit Engine.commit(seconds)", ""),
    "Engine::rebuilding": ("sl_engine_info.rebuilding", "Engine.rebuilding", ""),
    "Engine::config": ("sl_engine_get_config", "Engine.config", ""),
    "Engine::clear_overrides": ("sl_engine_clear_override", "Engine.clear_overrides", "in C with null items"),
    "Engine::hide": ("sl_engine_set_hidden", "Engine.hide", ""),
    "Engine::show": ("sl_engine_set_hidden", "Engine.show", ""),
    "Engine::override_of": ("sl_engine_get_override", "Engine.override_of", ""),
    "Engine::pick": ("sl_engine_pick sl_engine_pick_ghosts sl_engine_pick_ray",
                     "Engine.pick Engine.pick(ghosts) Engine.pick_ray", ""),
    "Engine::preparing_picks": ("sl_engine_info.preparing_picks", "Engine.preparing_picks", ""),
    "Engine::items_in": ("sl_engine_items_in sl_engine_items_in_planes", "Engine.items_in Engine.items_in_planes", ""),
    "Engine::use_context": ("sl_engine_use_context sl_engine_use_context_for sl_engine_abandon_context",
                            "Engine.use_context Engine.use_context(seconds) Engine.abandon_context", ""),
    "Engine::plan": ("sl_engine_info.culler sl_engine_explain", "Engine.culler Engine.plan", ""),
    "Engine::snapshot": ("-", "-", "the order of items is for renderers in C++; other functions tell of items"),
    "Engine::visible": ("sl_engine_visible", "Engine.visible_items", "ids instead of slots"),
    "Engine::memory": ("sl_engine_get", "Engine.memory", ""),
    "Engine::controller": ("sl_engine_get_controller", "Engine.controller", ""),
    "ItemStyle::colour": ("sl_item_style.use_colour sl_item_style.colour", "Engine.set_override(colour)", ""),
    "RayFilter::sections": ("sl_ray.section_count sl_ray.sections", "Engine.pick_ray(sections)", ""),
    "RayFilter::without": ("-", "-", "slots are internal; engines pass ghosts by themselves"),
    "RayFilter::cuts": ("sl_ray.leave_out_cuts", "Engine.pick_ray(cuts)", ""),
    "FrameReport::state": ("sl_frame_report.hybrid_state", "FrameReport.state", ""),
    "MemoryReport::bvh": ("sl_engine_info.hierarchy_bytes", "MemoryReport.bvh", ""),
    "Plan::culler": ("sl_engine_info.culler", "Engine.culler", ""),
    "Hit::slot": ("-", "-", SLOTS),
    "CullStates::of_slot": ("sl_cull_states.of_item", "CullStates.of_item", "by item instead of slot"),
    "CullBox::box": ("sl_cull_box.box", "CullStates.boxes", "in the world"),
    "CullBox::state": ("sl_cull_box.state", "CullStates.box_states", ""),
    "PagedEngine::create": ("sl_paged_engine_create sl_paged_config.progress", "PagedEngine PagedEngine(progress)",
                            "they open the scene cache, too"),
    "PagedEngine::scene": ("sl_paged_info.items sl_paged_info.pages sl_paged_info.bounds",
                           "PagedEngine.items PagedEngine.pages PagedEngine.bounds", "what a program needs of it"),
    "PagedEngine::memory": ("sl_paged_info.page_bytes sl_paged_info.page_limit",
                            "PagedEngine.page_bytes PagedEngine.page_limit", ""),
    "BoxCuller::create": ("sl_box_culler_create", "BoxCuller", ""),
    "BoxCuller::size": ("-", "BoxCuller.__len__", "C programs have said it themselves"),
    "BoxCuller::visible": ("sl_box_culler_visible sl_box_culler_visible_in sl_box_culler_visible_behind "
                           "sl_box_culler_visible_in_depth",
                           "BoxCuller.visible BoxCuller.visible(clip_from_world) BoxCuller.visible(occluders)", ""),
    "BoxCuller::update": ("sl_box_culler_update sl_box_culler_update_many", "BoxCuller.update", ""),
    "BoxCuller::bounds": ("-", "-", SLOTS),
    "BoxCuller::culler": ("-", "-", SLOTS),
    "BoxCuller::indices": ("-", "-", SLOTS),
    "OccluderRaster::add_box": ("sl_occluder_raster_add_largest", "OccluderRaster.add_largest", ""),
    "OccluderRaster::add_within": ("-", "-", "occluder polygons within solids are for engines"),
    "OccluderRaster::find_seen": ("-", "-", "occluder polygons within solids are for engines"),
    "OccluderRaster::build": ("sl_box_culler_visible_behind", "BoxCuller.visible(occluders)", "culling builds it"),
    "OccluderRaster::distances": ("sl_occluder_raster_read", "OccluderRaster.distances", "in Python rows from the top"),
    "OccluderRaster::distances_of_rows": ("-", "-", "for threads in C++"),
}
# Structs of settings by the member that holds them, and where they are.
SETTINGS = {
    "engine/internal/settings.inc": ("EngineConfig", "PagedConfig"),
    "importers/internal/settings.inc": ("ImportOptions", "WriteOptions"),
}
GROUPS = {"culling": "CullingConfig", "drawing": "DrawingConfig", "looks": "Looks", "losses": "LossConfig",
          "context": "ContextConfig", "depth_shading": "DepthShading", "hatching": "Hatching", "edges": "Edges",
          "background": "Background", "controller": "ControllerConfig"}
SETTING_HEADERS = ["engine/engine_config.h", "engine/looks.h", "engine/paged/paged_engine.h", "gpuprims/surroundings.h",
                   "culling/hybrid/controller.h", "importers/import.h", "importers/write_file.h"]
NO_SETTINGS = {"runner": "threads of C++",
               "context.application": "what finds GL's functions is an argument in C and Python",
               "culling.controller.rendering": "follows draw", "progress": "an argument in C and Python",
               "report": "what reading a cache will report is that of the scene"}


# --- headers ---------------------------------------------------------------------------------------------------------

def without_comments(text):
    text = re.sub(r"/\*.*?\*/", " ", text, flags=re.S)
    return re.sub(r"//[^\n]*|^\s*#[^\n]*(?:\\\n[^\n]*)*", " ", text, flags=re.M)


def body_after(text, start):
    """What stands between the first brace from `start` on and its closing one."""
    begin = text.index("{", start)
    depth = 0
    for i in range(begin, len(text)):
        depth += {"{": 1, "}": -1}.get(text[i], 0)
        if depth == 0:
            return text[begin + 1 : i]
    raise ValueError("braces do not match")


def split(text, separator):
    """At separators that are in no bracket. Where statements are split, the body of a function ends one, too."""
    parts, depth, part = [], 0, ""
    for c in text:
        if c in "({[":
            depth += 1
        elif c in ")}]":
            depth -= 1
        if c == separator and depth == 0:
            parts.append(part)
            part = ""
            continue
        part += c
        if separator == ";" and c == "}" and depth == 0 and re.search(r"\)[\w\s:]*\{", part):
            parts.append(part)
            part = ""
    return [p.strip() for p in [*parts, part] if p.strip()]


def without_templates(text):
    while True:
        shorter = re.sub(r"<[^<>]*>", " ", text)
        if shorter == text:
            return text
        text = shorter


def fields(body):
    found = []
    for statement in split(body, ";"):
        declared = re.sub(r"\{.*\}", " ", statement, flags=re.S)
        no_field = re.match(r"friend|using|static|enum|struct|union|bool operator", statement)
        if no_field or "(" in without_templates(declared.split("=")[0]):
            if "(*" not in declared:
                continue
            found.append(re.search(r"\(\*(\w+)\)", declared).group(1))
            continue
        for declarator in split(without_templates(statement), ","):
            name = re.sub(r"\{.*|=.*|\[.*", "", declarator, flags=re.S).split()
            found.append(name[-1].lstrip("*&"))
    return found


def functions(body, name):
    public = re.split(r"\bprivate:|\bprotected:", body.split("public:", 1)[1])[0]
    found = []
    for statement in split(without_templates(public), ";"):
        if re.match(r"friend|using|enum|struct", statement) or "(" not in statement:
            continue
        function = re.search(r"([~\w]+|operator\S+)\s*\(", statement).group(1)
        if function not in (name, "~" + name) and not function.startswith("operator") and function not in found:
            found.append(function)
    return found


def of_c(root):
    text = without_comments(filled(root, "bindings/c/sightline.h.in"))
    found = set(re.findall(r"SL_API [\w\s*]*?\b(sl_\w+)\(", text))
    found |= set(re.findall(r"\b(SL_\w+) = ", text))
    for struct in re.finditer(r"typedef struct (\w+) \{", text):
        found.add(struct.group(1))
        found |= {f"{struct.group(1)}.{field}" for field in fields(body_after(text, struct.start()))}
    return found


# --- stubs -----------------------------------------------------------------------------------------------------------

def arguments(function):
    return [a.arg for a in [*function.args.args, *function.args.kwonlyargs] if a.arg != "self"]


def name_of(node):
    return getattr(node, "name", None) or getattr(getattr(node, "target", None), "id", "")


def of_python(root):
    tree = ast.parse(filled(root, "bindings/python/sightline/_sightline.pyi.in"))
    found = set()

    def add(name, node):
        if isinstance(node, ast.FunctionDef):
            found.add(name)
            found.update(f"{name}({argument})" for argument in arguments(node))
        elif isinstance(node, ast.AnnAssign):
            found.add(name)

    for node in tree.body:
        if isinstance(node, ast.ClassDef):
            found.add(node.name)
            for member in node.body:
                if isinstance(member, ast.FunctionDef) and member.name == "__init__":
                    found.update(f"{node.name}({argument})" for argument in arguments(member))
                else:
                    add(f"{node.name}.{name_of(member)}", member)
        else:
            add(name_of(node), node)
    return found


# --- names -----------------------------------------------------------------------------------------------------------

def filled(root, template):
    return "\n".join(settings.fill(settings.Writer(root), (root / template).read_text()))


def rows(root):
    """Each name of C++ with its names in C and in Python, and why."""
    for header, structs in RULES.items():
        text = without_comments((root / header).read_text())
        for name, (c, python) in structs.items():
            struct = re.search(rf"\bstruct {name}\b[^;{{]*\{{", text)
            start = struct or re.search(rf"\bclass (?:\w+ )?{name}\s*\{{", text)
            body = body_after(text, start.start())
            for member in fields(body) if struct else functions(body, name):
                yield f"{name}::{member}", EXCEPTIONS.get(f"{name}::{member}",
                                                          (c.format(member), python.format(member), ""))


def unknown_names(root):
    known = {"C": of_c(root), "Python": of_python(root)}
    listed = dict(rows(root))
    for cpp, (c, python, why) in listed.items():
        for language, names in (("C", c), ("Python", python)):
            if names == "-" and not why:
                yield f"{cpp}: a dash for {language}, and no reason"
            yield from (f"{cpp}: {language} has no {name}" for name in names.split()
                        if name != "-" and name not in known[language])
    yield from (f"{name}: C++ has no such thing" for name in EXCEPTIONS if name not in listed)


def unlisted_settings(root):
    text = "".join(without_comments((root / name).read_text()) for name in SETTING_HEADERS)

    def paths(struct, before=""):
        for field in fields(body_after(text, re.search(rf"\bstruct {struct}\b[^;{{]*\{{", text).start())):
            yield from paths(GROUPS[field], f"{before}{field}.") if field in GROUPS else [before + field]

    for file, structs in SETTINGS.items():
        listed = [".".join(setting.path) for setting in settings.read(root / file)[1]]
        for path in {path: 0 for struct in structs for path in paths(struct)}:
            if path not in NO_SETTINGS and listed.count(path) != 1:
                yield f"{path}: expected once in {file}, found {listed.count(path)} times"


def old_tables(root):
    page = root / "docs/reference/options.md"
    if settings.with_table(settings.Writer(root), page.read_text()) != page.read_text():
        yield "docs/reference/options.md: run cmake/settings.py page . docs/reference/options.md --write"


def main():
    root = pathlib.Path(sys.argv[1])
    found = [*unknown_names(root), *unlisted_settings(root), *old_tables(root)]
    for problem in found:
        print(problem, file=sys.stderr)
    if len(sys.argv) > 2:
        lines = [f"| `{cpp}` | {c} | {python} | {why} |" for cpp, (c, python, why) in rows(root)]
        pathlib.Path(sys.argv[2]).write_text("\n".join(["| C++ | C | Python | |", "|---|---|---|---|", *lines, ""]))
    return 1 if found else 0


if __name__ == "__main__":
    sys.exit(main())
