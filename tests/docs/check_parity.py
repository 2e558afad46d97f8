#!/usr/bin/env python3
"""Checks the table of docs/reference/api-parity.md: check_parity.py ROOT.

- Each field of the settings and reports of engines, each setting of imports, and each public function of Engine,
  PagedEngine, BoxCuller and OccluderRaster has a row, and nothing else.
- Each row names what C and Python have for it, or has a dash and says why.
- Each setting of engines is in engine/internal/settings.inc, which tells what Engine::configure() may change.
- What it names is in bindings/c/sightline/sightline.h and in bindings/python/sightline/_sightline.pyi.

Names in C: `function`, `struct`, `struct.field`, `CONSTANT`. In Python: `function`, `Class`, `Class.member`, and with arguments
`function(argument)`, `Class(argument)`, `Class.method(argument)`.
"""
import ast
import pathlib
import re
import sys

STRUCTS = {
    "engine/engine.h": ["EngineConfig", "CullingConfig", "DrawingConfig", "LossConfig", "ContextConfig", "PixelRectangle", "FrameReport", "LateReport", "LossReport",
                        "MemoryReport"],
    "engine/looks.h": ["Looks", "DepthShading", "Hatching"],
    "core/surroundings.h": ["Background"],
    "engine/plan.h": ["ScenePart", "PlanEntry", "Plan"],
    "engine/item_style.h": ["ItemStyle"],
    "engine/pick.h": ["Pick"],
    "core/ray.h": ["Ray"],
    "raytrace/tracer.h": ["Hit", "RayFilter"],
    "raytrace/exact_visibility.h": ["VisibleItem"],
    "engine/paged_engine.h": ["PagedConfig", "PagedReport"],
    "engine/image_tiles.h": ["ImageTile", "CroppedTile", "ImageTiles"],
    "culling/gpu/gpu_culler_config.h": ["GpuCullerConfig"],
    "culling/hybrid/controller.h": ["ControllerConfig"],
    "culling/cull_states.h": ["CullBox", "CullStates"],
    "gl/external_target.h": ["ExternalTarget"],
    "importers/import.h": ["ImportOptions"],
}
CLASSES = {
    "engine/engine.h": ["Engine"],
    "engine/paged_engine.h": ["PagedEngine"],
    "culling/box_culler.h": ["BoxCuller"],
    "culling/occlusion/occluder_raster.h": ["OccluderRaster"],
}


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


def of_cpp(root):
    for header, names in STRUCTS.items():
        text = without_comments((root / header).read_text())
        for name in names:
            start = re.search(rf"\bstruct {name}\b[^;{{]*\{{", text)
            yield from (f"{name}::{field}" for field in fields(body_after(text, start.start())))
    for header, names in CLASSES.items():
        text = without_comments((root / header).read_text())
        for name in names:
            start = re.search(rf"\bclass (?:\w+ )?{name}\s*\{{", text)
            yield from (f"{name}::{function}" for function in functions(body_after(text, start.start()), name))


def settings(root):
    """Paths of all settings, as settings.inc names them."""
    text = "".join(without_comments((root / "engine" / name).read_text()) for name in ("engine.h", "looks.h"))
    groups = {"culling": "CullingConfig", "drawing": "DrawingConfig", "looks": "Looks", "losses": "LossConfig",
              "context": "ContextConfig"}

    def of(struct):
        return fields(body_after(text, re.search(rf"\bstruct {struct}\b[^;{{]*\{{", text).start()))

    def paths(struct, before=""):
        for field in of(struct):
            yield from paths(groups[field], f"{before}{field}.") if field in groups else [before + field]

    yield from paths("EngineConfig")


def of_c(root):
    text = without_comments((root / "bindings/c/sightline/sightline.h").read_text())
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
    tree = ast.parse((root / "bindings/python/sightline/_sightline.pyi").read_text())
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


# --- the table -------------------------------------------------------------------------------------------------------

def rows(page):
    for line in page.splitlines():
        cells = [cell.strip() for cell in line.strip().strip("|").split("|")]
        if line.startswith("| `") and len(cells) == 4:
            yield cells


def problems(root):
    page = (root / "docs" / "reference" / "api-parity.md").read_text()
    expected, listed = list(of_cpp(root)), []
    known = {"C": of_c(root), "Python": of_python(root)}
    for cpp, c, python, why in rows(page):
        names = re.findall(r"`([^`]+)`", cpp)
        listed += names
        for name in names:
            if name not in expected:
                yield f"{name}: C++ has no such thing"
        for language, cell in (("C", c), ("Python", python)):
            if cell == "—":
                if not why:
                    yield f"{cpp}: a dash for {language}, and no reason"
                continue
            found = re.findall(r"`([^`]+)`", cell)
            if not found:
                yield f"{cpp}: expected names of {language} or a dash, found \"{cell}\""
            for name in found:
                if name not in known[language]:
                    yield f"{cpp}: {language} has no {name}"
    for name in expected:
        if listed.count(name) != 1:
            yield f"{name}: expected one row, found {listed.count(name)}"


def unlisted_settings(root):
    listed = re.findall(r"^SIGHTLINE_SETTING\(([\w.]+),", (root / "engine/internal/settings.inc").read_text(), flags=re.M)
    for path in settings(root):
        if listed.count(path) != 1:
            yield f"{path}: expected once in engine/internal/settings.inc, found {listed.count(path)} times"


def main():
    root = pathlib.Path(sys.argv[1])
    found = [*problems(root), *unlisted_settings(root)]
    for problem in found:
        print("docs/reference/api-parity.md: " + problem, file=sys.stderr)
    return 1 if found else 0


if __name__ == "__main__":
    sys.exit(main())
