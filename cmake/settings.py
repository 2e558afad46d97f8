#!/usr/bin/env python3
"""Writes what engine/internal/settings.inc and importers/internal/settings.inc say of settings into other languages.

    settings.py fill ROOT TEMPLATE OUT   replaces lines of the template that are "@name@" by what block() makes
    settings.py page ROOT PAGE           prints the page with its table anew; --write: changes it
"""
import ast
import pathlib
import re
import sys

BOTH, UNPAGED, ENGINE, CONTROLLER, PAGED = "", "UNPAGED_", "ENGINE_", "CONTROLLER_", "PAGED_"
IMPORT, WRITE = "IMPORT_", "WRITE_"  # of the other file
OF_STRUCT = {"engine": (BOTH, UNPAGED, ENGINE, CONTROLLER), "paged": (BOTH, UNPAGED, PAGED), "import": (IMPORT,),
             "write": (WRITE,)}
IN_PYTHON = {"engine": (BOTH, UNPAGED, ENGINE), "paged": (BOTH, PAGED), "import": (IMPORT,), "write": (WRITE,)}

# type: of the C struct's field, of the Python stub
TYPES = {
    "flag": ("int32_t {}", "bool"),
    "int": ("int32_t {}", "int"),
    "count": ("uint32_t {}", "int"),
    "bytes": ("uint64_t {}", "int"),
    "float": ("float {}", "float"),
    "double": ("double {}", "float"),
    "colour": ("float {}[3]", "ArrayLike"),
    "optional_colour": ("sl_optional_colour {}", "Optional[ArrayLike]"),
    "direction": ("double {}[3]", "ArrayLike"),
    "part": ("sl_scene_part {}", "tuple[int, int]"),
    "path": ("const char* {}", "Optional[_Path]"),
}
# Structs of the C API by the member of EngineConfig, and what is written before each.
STRUCTS = {
    "controller": ("sl_controller_config", "When a hybrid takes which culler: sightline/culling/hybrid/controller.h."),
    "culling": ("sl_culling_config", "Which items are found visible, and by which means."),
    "depth_shading": ("sl_depth_shading", "Shading and lines by the depth of the image."),
    "hatching": ("sl_hatching", "Lines on what section planes cut."),
    "edges": ("sl_edges", "Lines along the edges of items."),
    "background": ("sl_background", "What is behind everything."),
    "looks": ("sl_looks", "Shading, lines, light and background: sightline/engine/looks.h."),
    "drawing": ("sl_drawing_config", "The image: its contents and its looks."),
    "losses": ("sl_loss_config", "What lets an image lack items, so that it costs less. All are off by default."),
    "context": ("sl_context_config", "Where the engine draws."),
}


class Setting:
    def __init__(self, engines, arguments):
        self.engines = engines
        path, self.name, self.type, self.change, _, _, self.range, self.default, self.help = arguments
        self.path = path.split(".")
        self.choice = self.type.removeprefix("optional_")  # where the type is one


def split(text):
    """Arguments of a macro: texts as such."""
    parts = re.findall(r'((?:"(?:[^"\\]|\\.)*"\s*)+|[^,"]+)(?:,|$)', text, flags=re.S)
    return [ast.literal_eval(f"({part.strip()})") if part.strip().startswith('"') else part.strip() for part in parts]


def read(file, only=BOTH):
    text = re.sub(r"^(//|#).*$", "", file.read_text(), flags=re.M)
    calls = re.findall(r"SIGHTLINE_(CHOICE|\w*SETTING)\((.*?)\)\n(?=\n*SIGHTLINE|\n*$)", text, flags=re.S)
    choices = {}
    settings = []
    for macro, arguments in calls:
        if macro == "CHOICE":
            _, prefix, *names = split(arguments)
            choices[prefix] = names
        else:
            settings.append(Setting(macro.removesuffix("SETTING") or only, split(arguments)))
    return choices, settings


class Writer:
    def __init__(self, root):
        of_imports, imports = read(root / "importers/internal/settings.inc", IMPORT)
        of_engines, engines = read(root / "engine/internal/settings.inc")
        self.of_engines, self.of_imports = of_engines, of_imports
        self.choices, self.settings = {**of_engines, **of_imports}, engines + imports

    # --- C

    def enumerator(self, prefix, name):
        return f"SL_{prefix}_{name}".upper().replace("-", "_")

    def c_enums(self, choices):
        for prefix, names in choices.items():
            first = [s.default for s in self.settings if s.type == "optional_" + prefix]
            values = ", ".join(f"{self.enumerator(prefix, name)} = {i}" for i, name in enumerate(first + names))
            line = f"enum {{ {values} }};"
            yield line if len(line) <= 120 else "enum {\n  " + values.replace(", ", ",\n  ") + "\n};"

    def c_type(self, setting):
        return TYPES[setting.type][0] if setting.type in TYPES else "int32_t {}"

    def c_default(self, setting):
        if setting.choice in self.choices:
            return self.enumerator(setting.choice, setting.default)
        return setting.default or "0"

    def c_comment(self, setting):
        values = [f"SL_{setting.choice.upper()}_..."] if setting.choice in self.choices else [setting.range] if setting.range else []
        return setting.help + "".join(f" ({value})" for value in values)

    def tree(self, settings):
        """Fields of a struct in order: settings, and the structs that are fields by their names."""
        top = {}
        for setting in settings:
            inner = top
            for group in setting.path[:-1]:
                inner = inner.setdefault(group, {})
            inner[setting.path[-1]] = setting
        return top

    def c_fields(self, fields):
        for name, field in fields.items():
            if isinstance(field, dict):
                yield f"  {STRUCTS[name][0]} {name};"
            else:
                yield from comment_lines(self.c_comment(field), "  ")
                yield f"  {self.c_type(field).format(name)};"

    def c_defaults(self, fields):
        return ", ".join(STRUCTS[name][0].upper() + "_INIT" if isinstance(field, dict) else self.c_default(field)
                         for name, field in fields.items())

    def c_groups(self, fields):
        for name, field in fields.items():
            if not isinstance(field, dict):
                continue
            yield from self.c_groups(field)
            struct, help = STRUCTS[name]
            yield from comment_lines(help, "")
            yield f"typedef struct {struct} {{"
            yield from self.c_fields(field)
            yield f"}} {struct};"
            yield from defaults_of(f"{struct.upper()}_INIT", f"{{ {self.c_defaults(field)} }}")
            yield ""

    def block(self, name):
        of, what = name.split("_", 1)
        settings = [s for s in self.settings if s.engines in OF_STRUCT[of]]
        if what == "enums":
            return self.c_enums(self.of_imports if of == "import" else self.of_engines)
        if what == "groups":
            return self.c_groups(self.tree(settings))
        if what == "fields":
            return self.c_fields(self.tree(settings))
        if what == "defaults":
            return defaults_of(f"SL_{of.upper()}_DEFAULTS", self.c_defaults(self.tree(settings)))
        return getattr(self, what)([s for s in settings if s.engines in IN_PYTHON[of]])

    # --- Python

    def python_type(self, setting):
        if setting.choice not in self.choices:
            return TYPES[setting.type][1]
        names = "Literal[" + ", ".join(f'"{name}"' for name in self.choices[setting.choice]) + "]"
        return f"Optional[{names}]" if setting.type != setting.choice else names

    def python_arguments(self, settings):
        for s in settings:
            yield f"        {s.name}: {self.python_type(s)}" + (" = ...," if s.default else ",")

    def python_changeable(self, settings):
        return self.python_arguments([s for s in settings if s.change == "CHANGEABLE"])

    def python_controller(self, _):
        numbers = [s for s in self.settings if s.engines == CONTROLLER]
        for s in numbers:
            yield f"    {s.name}: {self.python_type(s)}"
        yield "    def __init__(\n        self,\n        *,"
        yield from self.python_arguments(numbers)
        yield "    ) -> None: ..."

    # --- pages

    def table(self):
        yield "| name | in C and C++ | values | default | meaning |"
        yield "| --- | --- | --- | --- | --- |"
        for s in self.settings:
            if s.engines in (IMPORT, WRITE, CONTROLLER):
                continue
            values = ", ".join(self.choices.get(s.choice, [])) or s.range or {
                "flag": "on or off", "path": "a path", "part": "index, count"}.get(s.type, "a number")
            default = s.default
            if s.type == "flag":
                default = {"0": "off", "1": "on"}[default]
            elif s.type in ("path", "optional_colour"):
                default = "none"
            elif s.type in ("float", "colour"):
                default = default.replace("f", "")
            other = {UNPAGED: " Not paged.", PAGED: " Paged."}.get(s.engines, "")
            yield f"| `{s.name}` | `{'.'.join(s.path)}` | {values} | {default or 'must be given'} | {s.help}.{other} |"


def comment_lines(text, indent):
    words, line = f"/* {text}".split(), indent
    words[-1] += " */"
    for word in words:
        if len(line) + len(word) > 119:
            yield line.rstrip()
            line = indent + " * "
        line += word + " "
    yield line.rstrip()


def defaults_of(name, value):
    """A macro of several lines, which end below column 120."""
    lines, line = [f"#define {name}"], " "
    for word in value.split(" "):
        if len(line) + len(word) > 116:
            lines.append(line)
            line = "   "
        line += " " + word
    return [text + " \\" for text in lines] + [line]


def fill(writer, template):
    for line in template.splitlines():
        found = re.fullmatch(r"@(\w+)@", line)
        if found:
            yield from writer.block(found.group(1))
        else:
            yield line


def with_table(writer, page):
    return re.sub(r"(<!-- settings -->\n\n).*?(<!-- end of settings -->)",
                  lambda found: found.group(1) + "\n".join([*writer.table(), "", ""]) + found.group(2), page, flags=re.S)


def main(command, root, file, out=None):
    writer, text = Writer(pathlib.Path(root)), pathlib.Path(file).read_text()
    made = "\n".join(fill(writer, text)) + "\n" if command == "fill" else with_table(writer, text)
    target = pathlib.Path(file if out == "--write" else out) if out else None
    if not target:
        print(made, end="")
        return
    if target.is_symlink():
        target.unlink()
    if not target.exists() or target.read_text() != made:
        target.parent.mkdir(parents=True, exist_ok=True)
        target.write_text(made)


if __name__ == "__main__":
    main(*sys.argv[1:])
