"""The places of a source that a small fault may change, and the lines that it may become."""
import pathlib
import re

# what is looked for, and what takes its place
OPERATORS = [
    (r" < ", [" <= ", " > "]),
    (r" > ", [" >= ", " < "]),
    (r" <= ", [" < "]),
    (r" >= ", [" > "]),
    (r" == ", [" != "]),
    (r" != ", [" == "]),
    (r" && ", [" || "]),
    (r" \|\| ", [" && "]),
    (r" \+ ", [" - "]),
    (r" - ", [" + "]),
    (r" \* ", [" / "]),
    (r" / ", [" * "]),
    (r"\btrue\b", ["false"]),
    (r"\bfalse\b", ["true"]),
    (r"(?<=[(& |])!(?=[a-z(])", [""]),
    (r"std::max\(", ["std::min("]),
    (r"std::min\(", ["std::max("]),
    (r"\+\+(?=[a-z])", ["--"]),
    (r"\bcontinue;", ["break;"]),
]
STATEMENT = re.compile(r"^\s+(?!return\b|const\b|static\b|auto\b|using\b|case\b|break\b)[\w:.>()\[\]-]+(\(| = | \+= ).*;\s*$")
GUARD = re.compile(r"^\s+if \(.*\) (return\b.*|continue);\s*$")  # a check that refuses: the fault leaves it out
LEFT_ALONE = re.compile(r"^\s*(//|#|template|namespace|static_assert|using )|TANDEM_|operator|<<|Tell\(|Notify\(")
# a declaration of a member or of a constant without a value computes nothing
DECLARATION = re.compile(r"^\s+[\w:<>, ]+ \w+_?( = (true|false|\w+))?;\s*$")


def mutants_of(root: pathlib.Path, file: str):
    """Returns all places of a file: dictionaries with file, line (from 0), was and became, which are whole lines."""
    found = []
    lines = (root / file).read_text().splitlines()
    for number, line in enumerate(lines):
        code = line.split("//")[0].rstrip()
        if not code.strip() or LEFT_ALONE.search(code):
            continue
        became = []
        for pattern, others in OPERATORS:
            for match in re.finditer(pattern, code):
                became += [code[: match.start()] + other + code[match.end():] for other in others]
        # a statement that goes on from the line above, or into the next, is not one by itself
        whole = number == 0 or re.search(r"[;{}:]\s*$|^\s*$|^\s*//", lines[number - 1].split("//")[0] or " ")
        if whole and GUARD.match(code):
            became.append("")
        elif whole and STATEMENT.match(code) and not DECLARATION.match(code):
            became.append("")
        found += [{"file": file, "line": number, "was": line, "became": new} for new in dict.fromkeys(became)]
    return found
