"""Compares the table of folders in docs/develop/architecture.md with what CMake links: no arrow is missing, none is extra.

usage: check_map.py REPOSITORY
"""
import pathlib
import re
import sys


def table(page):
    """The folders that each folder may use, by the page; without those that use everything."""
    uses = {}
    for folders, used in re.findall(r"^\| ((?:`[\w/]+/`(?:, )?)+) \|.*\| ([^|]*) \|$", page, re.MULTILINE):
        names = used.split(";")[0]
        if names in ("the library", "the source tree", ""):
            continue
        for folder in re.findall(r"`([\w/]+)/`", folders):
            uses[folder] = {name.strip() for name in names.split(",")}
    return uses


def calls(text, *names):
    """The arguments of calls in a CMakeLists.txt; a loop over names counts as a call with each of them."""
    text = re.sub(r"#.*", "", text)
    for loop in re.finditer(r"foreach\((\w+) ([^)]*)\)(.*?)endforeach", text, re.DOTALL):
        each = [loop[3].replace("${" + loop[1] + "}", value) for value in loop[2].split()]
        text = text.replace(loop[0], "\n".join(each))
    return re.findall(r"\b(?:" + "|".join(names) + r")\(([^)]*)\)", text)


def main(root):
    uses = table((root / "docs/develop/architecture.md").read_text())
    lists = {path.parent.relative_to(root).as_posix(): path.read_text() for path in root.glob("*/CMakeLists.txt")}
    lists |= {path.parent.relative_to(root).as_posix(): path.read_text() for path in root.glob("*/*/CMakeLists.txt")}
    folder_of = {}
    for folder, text in lists.items():
        for made in calls(text, "sightline_library"):
            folder_of[made.split()[0]] = folder

    def room_of(folder):
        """The row of the table that a folder belongs to."""
        while folder and folder not in uses:
            folder = folder.rpartition("/")[0]
        return folder

    links = {}
    for folder, text in lists.items():
        if not room_of(folder):
            continue
        for arguments in calls(text, "sightline_library", "target_link_libraries", "sightline_module"):
            for name in re.findall(r"sightline::(\w+)", arguments):
                links.setdefault(room_of(folder), set()).add(room_of(folder_of.get(name, name)))
    wrong = [f"{folder}: the table has no such folder in CMake" for folder in uses if folder not in lists]
    for folder, used in uses.items():
        linked = links.get(folder, set()) - {folder}
        others = {name for name in used if name in lists}
        wrong += [f"{folder} links {name}, and the table does not say so" for name in sorted(linked - used)]
        wrong += [f"{folder} does not link {name}, and the table says so" for name in sorted(others - linked)]
        wrong += [f"{folder} uses {name}, which is no folder" for name in sorted(used - others - OTHERS)]
    for folder in sorted(set(folder_of.values())):
        if not room_of(folder):
            wrong.append(f"{folder}: a library that the table does not have")
    for line in wrong:
        print("architecture.md:", line)
    return 1 if wrong else 0


OTHERS = {"GLM", "tl-expected"}  # libraries, where no folder is used

if __name__ == "__main__":
    sys.exit(main(pathlib.Path(sys.argv[1])))
