"""Numbers as people read them: three significant digits, never more than the measurement has."""
import math

SUPERSCRIPT = str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹")
NOTHING = "n/a"  # not measured, or no finite number


def is_number(value):
    return isinstance(value, (int, float)) and not isinstance(value, bool) and math.isfinite(value)


def times(value, factor):
    return factor * value if is_number(value) else math.nan


def power_of_ten(exponent):
    return "10" + str(exponent).translate(SUPERSCRIPT)


def number(value, digits=3):
    """Three significant digits; powers of ten beyond a million and below a ten-thousandth."""
    if not is_number(value):
        return NOTHING
    if value == 0:
        return "0"
    exponent = math.floor(math.log10(abs(float(f"{value:.{digits - 1}e}"))))
    if exponent >= 6 or exponent < -4:
        return f"{value / 10 ** exponent:.{digits - 1}f}·{power_of_ten(exponent)}".replace("-", "−", 1)
    rounded = round(value, digits - 1 - exponent)
    return grouped(f"{rounded:.{max(0, digits - 1 - exponent)}f}")


def grouped(text):
    """12345 -> 12 345, by a narrow space that does not break; a minus sign that is one."""
    sign, text = ("−", text[1:]) if text.startswith("-") else ("", text)
    whole, dot, rest = text.partition(".")
    return sign + (f"{int(whole):,}".replace(",", "\u202f") if len(whole) > 4 else whole) + dot + rest


def exact(value):
    """A number that was chosen and not measured: all of its digits, no more."""
    return grouped(f"{value:.6f}".rstrip("0").rstrip(".")) if is_number(value) else NOTHING


def micro(value):
    """A signed difference of times in µs: hundredths at most."""
    if not is_number(value) or abs(value) >= 10:
        return signed(value)
    return f"{value:+.2f}".replace("-", "−") if round(value, 2) else "0"


def count(value):
    """A whole number, every digit of it."""
    return grouped(str(int(value))) if is_number(value) else NOTHING


def unit(value, name, digits=3):
    return f"{number(value, digits)} {name}" if is_number(value) else NOTHING


def share(value):
    """A fraction in per cent, hundredths at most; multiples beyond tenfold. Beyond thousandfold the reference has next to
    nothing, and no share can be told."""
    if not is_number(value):
        return NOTHING
    if value == 0:
        return "0 %"
    if abs(value) >= 1000:
        return "over 1000×" if value > 0 else "under −1000×"
    if abs(value) >= 10:
        return f"{number(value)}×"
    if abs(value) < 5e-5:
        return "< 0.01 %" if value > 0 else "> −0.01 %"
    return f"{number(100 * value) if abs(value) >= 0.1 else grouped(f'{100 * value:.2f}')} %"


def said(value):
    """A share in a sentence."""
    return share(value).replace("< ", "less than ")


def at_most(value, write=share):
    """For a sentence: "at most 3.1 %", "less than 0.01 %"."""
    if not is_number(value):
        return "an unknown amount"
    words = write(value)
    return f"less than {words[2:]}" if words.startswith("< ") else f"at most {words}"


def points(value):
    """A difference of shares, signed, in percentage points."""
    if not is_number(value):
        return NOTHING
    if abs(value) < 5e-5:
        return "about 0" if value else "0"
    if abs(value) >= 10:
        return f"{signed(100 * value)} points"
    return f"{'+' if value > 0 else ''}{share(value).replace('%', 'points')}"


def signed(value, digits=3):
    return f"{'+' if is_number(value) and value > 0 else ''}{number(value, digits)}"


def listed(words):
    """a, b and c."""
    words = list(words)
    return words[0] if len(words) == 1 else f"{', '.join(words[:-1])} and {words[-1]}" if words else "none"
