"""Fails when two sources of a library (of a LARGE one: in the same folder) or of a test program define the same name in their
unnamed namespaces: the release configuration compiles them as one (cmake/Skyquilt.cmake), where such names meet. What is the
same thing belongs in one header; what is not deserves a name that tells it apart."""
import collections
import pathlib
import re
import sys

ROOT = pathlib.Path(sys.argv[1])
LIBRARY = re.compile(r"skyquilt_(?:library|test)\((\w+)( LARGE)?([^)]*)\)")
OPENING = re.compile(r"^namespace \{$.*?^\}  // namespace$", re.M | re.S)
# Definitions at the left margin; overloads that differ in their parameters may share a name.
DEFINED = [
    re.compile(r"^(?:inline )?(?:static )?constexpr [^=({;]*?\b(\w+)\s*(?:\[[^\]]*\])*\s*[={]", re.M),
    re.compile(r"^const [^=({;]*?\b(\w+)\s*(?:\[[^\]]*\])*\s*[={]", re.M),
    re.compile(r"^(?:struct|class|enum class|enum) (?:\[\[\w+\]\] )?(\w+)\b(?=[^;]*[{=])", re.M),
]
ENUMERATORS = re.compile(r"^enum (?!class )[^{;]*\{([^}]*)\}", re.M)
ALIAS = re.compile(r"^using (\w+) = ([^;]+);", re.M)
FUNCTION = re.compile(r"^(?!using |struct |class |enum |namespace |return |else |typedef |#|//|\s)[\w:<>,&*\[\] ]*?[\w>&*] ?[&*]?"
                      r"\b(\w+)(\([^;{]*?\))(?: const| noexcept)* \{", re.M)


def types_of(parameters):
    """A parameter list without names and defaults, roughly: enough to tell overloads apart."""
    text = re.sub(r"\s+", " ", parameters)
    text = re.sub(r"=[^,)]*|\bconst |\b\w+::", "", text)
    return re.sub(r"\b\w+ ?(?=[,)])", "", text)


def names_of(path):
    """By name: what it stands for. Aliases of the same type may meet."""
    names = {}
    for block in OPENING.findall(path.read_text()):
        for pattern in DEFINED:
            names |= {(name, ""): path for name in pattern.findall(block)}
        for enumerators in ENUMERATORS.findall(block):
            names |= {(name, ""): path for name in re.findall(r"\b(k[A-Z]\w*)(?=\s*[,=]|\s*$)", enumerators)}
        names |= {(name, types_of(parameters)): path for name, parameters in FUNCTION.findall(block)}
        names |= {(name, ""): type_name for name, type_name in ALIAS.findall(block)}
    return names


problems = []
for lists in sorted(ROOT.rglob("CMakeLists.txt")):
    if {"build", "node_modules"} & set(lists.relative_to(ROOT).parts):
        continue
    for library, is_large, body in LIBRARY.findall(lists.read_text()):
        owners = collections.defaultdict(list)
        sources = body.split("HEADERS")[0].split("DEPS")[0]
        for source in re.findall(r"[\w./-]+\.cc\b", sources):
            path = lists.parent / source
            if path.exists():
                for name, meaning in names_of(path).items():
                    owners[path.parent if is_large else "", *name].append((path.relative_to(ROOT).as_posix(), meaning))
        for (group, name, parameters), places in sorted(owners.items()):
            if parameters:  # a function meets a type or a constant of its name
                places = places + owners.get((group, name, ""), [])
            if len({meaning for _, meaning in places}) > 1:
                paths = [path for path, _ in places]
                problems.append(f"{library}: {name}{parameters} is defined in {', '.join(paths)}")
print("\n".join(problems) or "no two sources that are compiled as one define the same name")
sys.exit(1 if problems else 0)
