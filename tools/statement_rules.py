#!/usr/bin/env python3
"""Rules on statements and parameter lists that a line pattern cannot check; called by tools/purity.

usage: tools/statement_rules.py FILE...

Prints file:line, the rule and the text.
A heuristic reader, not a parser: it takes a statement that it cannot classify for a declaration, so it reports no
statement that is none.
"""

import re
import sys

MAX_PARAMETERS = 6

# What precedes the expression within a statement: labels, else, if (...).
_PREFIX = re.compile(r"\s*(?:(?:public|private|protected)\s*:|case\s(?:[^:]|::)*:(?!:)|default\s*:|else\b|do\b|"
                     r"(?:if|for|while|switch)\s*(?:constexpr\s*)?\()")
_DECLARATION = re.compile(r"(?:using|typedef|template|friend|static|const|constexpr|inline|auto|struct|class|enum|"
                          r"extern|volatile|mutable|typename|unsigned|thread_local|explicit|virtual|alignas)\b")
_NAME = re.compile(r"(?:\+\+|--|\*|\(void\))*[A-Za-z_][\w:]*(?:<[^;<>=]*>(?=\())?")
_MEMBER = re.compile(r"\s*(?:\.|->)\s*~?[A-Za-z_]\w*(?:<[^;<>=()]*>(?=\())?|\+\+|--")
_GOES_ON = re.compile(r"\s*(?:(?:[-+*/|&^%]|<<|>>)?=(?!=)|,|\?|<<|&&|\|\||$)")
_PARAMETER = re.compile(r"\s*(?:const\s+|typename\s+)?[\w:]+(?:<.*>)?(?:\s*[&*]+|\s+)(?:const\s+)?[&*]*\s*\w*"
                        r"(?:\s*=.*)?$", re.S)


def blanked(text):
    """The text with comments, literals and preprocessor lines overwritten: positions and lines stay."""
    token = re.compile(r'//[^\n]*|/\*.*?\*/|R"(?P<tag>[^(\s]*)\(.*?\)(?P=tag)"|"(?:\\.|[^"\\\n])*"|'
                       r"(?<!\w)'(?:\\.|[^'\\\n])+'|(?m:^[ \t]*#(?:[^\n]*\\\n)*[^\n]*)", re.S)

    def blank(match):
        old = match.group()
        new = re.sub(r"[^\n]", " " if old[0] in "/# \t" else "x", old)
        return new if old[0] in "/# \t" else '"' + new[1:-1] + '"'

    return token.sub(blank, text)


def after_group(text, at):
    """The position after the bracket that closes the one at `at`."""
    depth = 0
    for i in range(at, len(text)):
        depth += text[i] in "([{"
        depth -= text[i] in ")]}"
        if depth == 0:
            return i + 1
    return len(text)


def is_initialiser(text, at):
    """Does the brace at `at` open a list of values, not a block?"""
    before = text[max(0, at - 200):at]
    word = before.rstrip()
    if before and not before[-1].isspace() and before[-1] not in "){;}":
        return True
    return word.endswith(tuple(",=(<>?:&|[")) or re.search(r"\breturn$", word) is not None or before.endswith("{")


def statements(text):
    """Yields (start, end, commas outside of brackets) of each statement that ends with a semicolon."""
    stack = []
    start, commas, depth = 0, [], 0
    for i, c in enumerate(text):
        if c in "([" or (c == "{" and is_initialiser(text, i)):
            stack.append(None)
            depth += 1
        elif c == "{":
            stack.append((start, commas, depth))
            start, commas, depth = i + 1, [], 0
        elif c in ")]}" and stack:
            outer = stack.pop()
            if outer is None:
                depth -= 1
            else:
                start, commas, depth = outer
                if depth == 0:
                    start, commas = i + 1, []
        elif c == "," and depth == 0:
            commas.append(i)
        elif c == ";" and depth == 0:
            yield start, i, commas
            start, commas = i + 1, []


def expression_start(text, start):
    while match := _PREFIX.match(text, start):
        start = after_group(text, match.end() - 1) if match.group().endswith("(") else match.end()
    while start < len(text) and text[start].isspace():
        start += 1
    return start


def is_expression(statement):
    if re.match(r"return\b", statement):
        return True
    name = _NAME.match(statement)
    if _DECLARATION.match(statement) or name is None:
        return False
    at = name.end()
    while True:
        if member := _MEMBER.match(statement, at):
            at = member.end()
        elif at < len(statement) and statement[at] in "([":
            at = after_group(statement, at)
        else:
            return _GOES_ON.match(statement, at) is not None


def in_template(text, begin, at):
    """Is the position within template arguments? Comparisons have a space before `<`, as clang-format writes them."""
    depth = 0
    for i in range(begin, at):
        depth += text[i] == "<" and (text[i - 1].isalnum() or text[i - 1] == "_")
        depth -= text[i] == ">" and depth > 0 and text[i - 1] != "-"
    return depth > 0


def chained(text):
    for start, end, commas in statements(text):
        if not commas:
            continue
        begin = expression_start(text, start)
        if not is_expression(text[begin:end]):
            continue
        if any(comma > begin and not in_template(text, begin, comma) for comma in commas):
            yield begin, "statements chained by commas"


def parts_of(arguments):
    """What commas separate, outside of all brackets and template arguments."""
    parts, depth, begin = [], 0, 0
    for i, c in enumerate(arguments):
        depth += c in "([{<"
        depth -= c in ")]}" or (c == ">" and arguments[i - 1] != "-")
        if c == "," and depth == 0:
            parts.append(arguments[begin:i])
            begin = i + 1
    return parts + [arguments[begin:]]


def long_lists(text):
    for match in re.finditer(r"[A-Za-z_][\w:]*\(", text):
        end = after_group(text, match.end() - 1)
        if text.count(",", match.end(), end) < MAX_PARAMETERS:
            continue
        parts = [part.strip() for part in parts_of(text[match.end():end - 1])]
        if len(parts) > MAX_PARAMETERS and all(" " in p and _PARAMETER.match(p) for p in parts):
            yield match.start(), f"a function of more than {MAX_PARAMETERS} parameters"


def main(files):
    for file in files:
        with open(file, encoding="utf-8") as source:
            text = blanked(source.read())
        lines = text.split("\n")
        for at, rule in [*chained(text), *long_lists(text)]:
            line = text.count("\n", 0, at) + 1
            print(f"{file}:{line}: {rule}: {lines[line - 1].strip()[:120]}")


if __name__ == "__main__":
    main(sys.argv[1:])
