"""Names of fasteners: words in several languages, and the numbers of standards."""

from __future__ import annotations

import itertools
import re
import unicodedata
from collections import Counter
from functools import lru_cache

from feeler.mockup import Mockup

PIPES = (
    "pipe pipes tube tubes tubing hose hoses line lines rohr rohrleitung leitung schlauch tuyau tuyaux tubo tubi tubos "
    "tubazione manguera durite"
)
"""Words of names of what fittings join."""

KINDS = {
    "bolt": "bolt bolts hexbolt setbolt bolzen sechskantschraube perno pernos tornillo tornillos boulon boulons "
    "bullone bulloni bulon bulones",
    "screw": "screw screws capscrew setscrew grubscrew machinescrew thumbscrew thumbscrews wingscrew wingscrews "
    "schraube zylinderschraube gewindestift gewindestifte vis vite viti grano prisionero shcs",
    "nut": "nut nuts hexnut locknut wingnut jamnut capnut unionnut mutter sechskantmutter ecrou ecrous tuerca tuercas "
    "dado dadi",
    "stud": "stud studs stiftschraube gewindestange gewindebolzen stehbolzen schraubenbolzen schweissbolzen goujon "
    "goujons prigioniero prigionieri esparrago esparragos",
}
"""Words, in lower case, by kind of fastener."""

ENDINGS = {"mutter": "nut", "muttern": "nut", "schraube": "screw", "schrauben": "screw"}
"""How words end that are two in one, such as "Flügelmutter"."""

BOLT_OR_PIN = "bolzen perno pernos bulon bulones goujon goujons"
"""Those that also name pins: a rod without a head for a tool and without a thread is one."""

STANDARDS = {
    "bolt": "478 479 480 603 609 910 931 933 960 961 4014 4016 4017 4018 6921 8765 8676",
    "screw": "84 316 653 906 908 912 913 914 915 916 923 963 964 965 966 1207 1580 2009 4026 4027 4028 4029 4762 "
    "6304 6306 7045 7046 7047 7379 7380 7984 7985 7991 10642",
    "nut": "315 431 439 466 467 546 547 548 555 557 562 917 934 935 936 937 979 980 981 982 985 986 1587 1804 2982 "
    "4032 4033 4034 4035 6330 6331 6923 6924 7040 7042 10511 70852",
    "stud": "835 938 939 976",
}
"""Numbers of DIN and ISO standards by kind of fastener."""

BY_HAND = (
    "thumb thumbscrew thumbscrews knurled tommy raendelschraube raendelschrauben randelschraube randelschrauben "
    "knebelschraube knebelschrauben moletee moleteado zigrinata godronata"
)
"""Words of names of screws that are turned by hand."""

RETAINERS = {
    "circlip": "circlip circlips snapring snaprings retainingring retainingrings seeger seegerring sicherungsring "
    "wellensicherungsring bohrungssicherungsring sicherungsscheibe haltering sprengring seegering eclip eclips cclip "
    "cclips ering erings truarc",
    "pin": "pin pins dowel dowels cotter cotters splitpin splitpins rollpin rollpins stift stifte zylinderstift "
    "passstift spannstift kegelstift kerbstift federstift haltestift fixierstift zentrierstift "
    "sicherungsstift kerbnagel splint splinte sicherungssplint federsplint federstecker klappstecker "
    "spannhuelse spannhulse springpin springpins taperpin hairpin hairpins hairpinclip hairpinclips rclip "
    "rclips betaclip hitchpin linchpin lynchpin clevispin steckbolzen gelenkbolzen lagerbolzen drehbolzen "
    "passbolzen achsbolzen kolbenbolzen sicherungsbolzen bolzen perno pernos bulon bulones goujon goujons",
    "clasp": "clip clips clamp clamps hoseclamp hoseclamps pipeclamp pipeclamps strap straps saddle saddles "
    "shaftcollar shaftcollars setcollar setcollars clampcollar clampcollars clampingcollar clampingcollars "
    "splitcollar splitcollars clampring clamprings clampingring clampingrings schelle rohrschelle schlauchschelle "
    "halteklammer spannschelle klemmschelle klemme klemmen schlauchklemme schlauchklemmen rohrklemme rohrklemmen "
    "klemmring klemmringe klemmstuck klemmstucke klemmstueck klemmstuecke stellring stellringe spannring spannringe "
    "spannband banjo banjos banjoeye banjofitting banjounion ringstutzen ringauge",
    "fitting": "adapter adapters adaptor adaptors fitting fittings connector connectors union unions nipple nipples "
    "nippel stutzen schlauchstutzen einschraubstutzen tuelle schlauchtulle schlauchtuelle verschraubung "
    "rohrverschraubung einschraubverschraubung coupling hosetail hosebarb barb",
}
"""Last words of names, of two words written as one too, by kind of what holds parts without a thread."""

RETAINER_ENDINGS = {
    "sicherungsring": "circlip",
    "sicherungsringe": "circlip",
    "sprengring": "circlip",
    "seegerring": "circlip",
    "zylinderstift": "pin",
    "spannstift": "pin",
    "schelle": "clasp",
    "schellen": "clasp",
}
"""How such words end that are two in one, such as "Innensicherungsring"."""

RETAINERS_FIRST = {
    "circlip": "circlip circlips anneauelastique anneauarret anneauretenue segmentarret anelloelastico anelloseeger "
    "anellosicurezza anelloarresto anelloritegno anilloelastico anilloseguridad anilloretencion anilloseeger "
    "anillobloqueo",
    "pin": "goupille goupilles broche broches axearticulation axechape axepivot spina spine spinotto spinotti copiglia "
    "copiglie coppiglia coppiglie pasador pasadores clavija clavijas",
    "clasp": "collier colliers brideserrage bagueserrage baguearret fascetta fascette morsetto morsetti "
    "anelloserraggio collareserraggio collarebloccaggio collarearresto abrazadera abrazaderas bridasujecion "
    "bridaapriete bridafijacion anilloapriete collarsujecion collarapriete collareje collarinapriete collarinsujecion",
    "fitting": "raccord raccords raccordo raccordi racor racores",
}
"""The same in languages in which they come first. "Bride" and "brida" alone are flanges."""

PLACES = (
    "upper lower top bottom front rear back left right lh rh inner outer inside outside internal external middle "
    "centre center inboard outboard fore aft half halves first second third small big large short long oben unten "
    "vorn vorne hinten links rechts innen aussen mitte mittig gross klein kurz lang oberteil unterteil halfte "
    "haelfte obere untere vordere hintere linke rechte avant arriere haut bas gauche droite droit interieur "
    "exterieur superieur inferieur milieu petit petite grand grande anteriore posteriore superiore inferiore "
    "sinistro destro sinistra destra interno esterno piccolo piccola delantero trasero superior inferior izquierdo "
    "izquierda derecho derecha interior exterior pequeno pequena geteilt geteilte einteilig zweiteilig"
)
"""Words behind a noun that say where or how large it is, or in how many pieces."""

KEEPERS = (
    "cover covers holder holders plate plates bracket brackets housing guard pliers groove tool deckel halter zange"
)
"""Last words of names of what is for a circlip, and is none."""

RETAINER_STANDARDS = {
    "circlip": "464 471 472 983 984 6799 7993",
    "pin": "1 7 94 1234 1444 1470 1471 1472 1473 1474 1475 1481 2338 2339 2340 2341 6325 7343 7346 7977 7978 7979 8734 "
    "8735 8740 8741 8742 8744 8745 8748 8750 8752 13337 22340 22341",
    "clasp": "705 3015 3016 3017 72571 72573",
}
"""Numbers of DIN and ISO standards by kind of retainer."""

SUPPORTING = "plug plugs stopfen verschlussstopfen ablassstopfen bouchon bouchons tappo tapon sensor sensors"
"""Words that confirm a likely shape but make no fastener of another one: plugs and sensors with a hexagon are screwed
in."""

OTHERS = (
    "washer washers plate hole holes boss union pipe tube clamp bracket housing cover wrench driver screwdriver socket "
    "key spanner gear shaft bearing spring ring gasket seal insert pin rivet"
)
"""Words that name something else if they come last: a bolt ring is not a bolt."""

GENERIC = "part body solid component compound shape object mesh node item product instance copy default assembly"
"""Words of generated names, which say nothing about a part."""

DRAWN = (
    "volume geom geometry geo cube cuboid cylinder sphere icosphere cone torus plane circle polygon extrude extrusion "
    "revolve"
)
"""Words of names that programs give to what they draw, in addition to `GENERIC`."""

HEADS = "head headed hd set cap button countersunk flat pan drive shoulder"
"""Words before "socket" that describe a screw."""

_KIND_OF_WORD = {word: kind for kind, words in KINDS.items() for word in words.split()}
_KIND_OF_STANDARD = {number: kind for kind, numbers in STANDARDS.items() for number in numbers.split()}
_RETAINER_OF_WORD = {word: kind for kind, words in RETAINERS.items() for word in words.split()}
_RETAINER_OF_FIRST = {word: kind for kind, words in RETAINERS_FIRST.items() for word in words.split()}
_RETAINER_OF_STANDARD = {number: kind for kind, numbers in RETAINER_STANDARDS.items() for number in numbers.split()}
_BOLT_OR_PIN = frozenset(BOLT_OR_PIN.split())
_BY_HAND = frozenset(BY_HAND.split())
_PLACES = frozenset(PLACES.split())
_KEEPERS = frozenset(KEEPERS.split())
_PIPES = frozenset(PIPES.split())
_OTHERS = frozenset(OTHERS.split())
_GENERIC = frozenset(GENERIC.split())
_DEFAULT = re.compile(rf"(?:{'|'.join([*GENERIC.split(), *DRAWN.split()])}|[ _.:#()\-\d])*", re.IGNORECASE)
_HEADS = frozenset(HEADS.split())
_SUPPORTING = frozenset(SUPPORTING.split())
_STANDARD = re.compile(r"(?:din|iso|en)[ _\-]*(?:en[ _\-]*)?(?:iso[ _\-]*)?(\d{2,5})(?!\d)", re.IGNORECASE)
_DIN = re.compile(r"(?:din[ _\-]*\d{1,2}|(?:din|iso)[ _\-]*(?:en[ _\-]*)?(?:iso[ _\-]*)?\d{3,5})(?!\d)", re.IGNORECASE)
_WITH = re.compile(r"[ _\-](?:with|without|mit|ohne|avec|sans|con|senza|sin)[ _\-]", re.IGNORECASE)
_METRIC = re.compile(r"(?<![A-Za-z])M\d")
_WORD = re.compile(r"[A-Z]?[a-z]+|[A-Z]+(?![a-z])")


@lru_cache(maxsize=1 << 16)  # each plan asks it of all parts
def kind_said(name: str) -> str | None:
    """The kind of fastener in a name: "bolt", "screw", "nut", "stud"; None if the name does not say.

    "other" if it names something else, "plug" if it confirms a likely shape.
    """
    standard = _STANDARD.search(name)
    if standard is not None and standard.group(1) in _KIND_OF_STANDARD:
        return _KIND_OF_STANDARD[standard.group(1)]
    plain = without_accents(name)
    # "set screw, socket" is a screw, and so is a screw with washer: words behind these describe it.
    phrases = [phrase for described in _WITH.split(plain) for phrase in re.split(r"[,;(]", described)]
    return next((said for said in map(_said, phrases) if said is not None), None)


def may_be_pin(name: str) -> bool:
    """Whether a name that says bolt or stud is as often that of a pin: "Bolzen", but not "Bolzen M8"."""
    return not _METRIC.search(name) and any(word in _BOLT_OR_PIN for word in words(without_accents(name)))


def retainer_said(name: str) -> str | None:
    """What holds parts without a head or a nut, in a name: "circlip", "pin", "clasp" for clamps and clips, or "fitting"
    for what joins pipes; None if the name does not say."""
    standard = _DIN.search(name)
    number = "" if standard is None else standard.group().lstrip("DINSOEdinsoe _-")
    if number in _RETAINER_OF_STANDARD:
        return _RETAINER_OF_STANDARD[number]
    plain = _WITH.split(without_accents(name))[0]
    # "retaining ring, external" is one: words after a comma may describe it.
    phrases = dict.fromkeys([plain, re.split(r"[,;(]", plain)[0]])
    return next((said for said in map(_retainer, phrases) if said is not None), None)


def _retainer(phrase: str) -> str | None:
    """As `retainer_said`, of words without accents."""
    every = words(phrase)
    while every and every[-1] in _PLACES:
        every.pop()
    said = [word for word in every if len(word) > 1]
    for last in ("".join(every[-2:]), "".join(said[-2:]), *said[-1:]):
        if last in _RETAINER_OF_WORD:
            return _RETAINER_OF_WORD[last]
    for ending, kind in RETAINER_ENDINGS.items():
        if said and said[-1].endswith(ending):
            return kind
    if said and said[-1] in _KEEPERS:
        return None
    nouns = [word for word in said if len(word) > 2]  # without "de", "di"
    pairs = [first + second for first, second in itertools.pairwise(nouns)]
    return next((_RETAINER_OF_FIRST[word] for word in [*nouns, *pairs] if word in _RETAINER_OF_FIRST), None)


def is_by_hand(name: str) -> bool:
    """Whether a name says that a screw is turned by hand."""
    return any(word in _BY_HAND for word in words(without_accents(name)))


def is_pipe(name: str) -> bool:
    """Whether a name says pipe or hose."""
    said = words(without_accents(name))
    return any(word in _PIPES or word.endswith(("rohr", "schlauch", "leitung")) for word in said)


def without_accents(name: str) -> str:
    """The name in plain letters."""
    plain = unicodedata.normalize("NFKD", name.replace("\u00df", "ss"))
    return "".join(each for each in plain if not unicodedata.combining(each))


def words(name: str) -> list[str]:
    """The words of a name, in lower case: "SnapRing_12" has "snap" and "ring"."""
    return [word.lower() for word in _WORD.findall(name)]


def telling_name(path: str, name: str | None = None) -> str:
    """The name of a part, by default the last step of its path; the step above if it is a default name of a program,
    such as "Solid1" and "Cylinder.001"."""
    folder, _, last = path.rpartition("/")
    known = [last if name is None else name, last, folder.rpartition("/")[2]]
    return next((each for each in known if not _DEFAULT.fullmatch(each)), known[0])


def name_of(mockup: Mockup, part: int) -> str:
    """What tells about a part: its name, or a default one's step above, if no other part is in that step."""
    known = mockup._remembered.get("telling names")
    if known is None:
        paths, names = mockup.part_paths, mockup.part_names
        within = Counter(path.rpartition("/")[0] for path in paths)
        known = [
            telling_name(path, name) if within[path.rpartition("/")[0]] == 1 else name
            for path, name in zip(paths, names, strict=True)
        ]
        mockup._remembered["telling names"] = known
    return str(known[part])


def says_nothing(name: str) -> bool:
    """Whether a name has no word about the part, as in "Part 12"."""
    return all(len(word) < 3 or word.lower() in _GENERIC for word in _WORD.findall(name))


def _said(phrase: str) -> str | None:
    words = [word.lower() for word in _WORD.findall(phrase)]
    words = [word for word in words if len(word) > 2]
    said = None
    for word, following in zip(words, [*words[1:], ""], strict=False):
        if word in _KIND_OF_WORD:
            said = _KIND_OF_WORD[word]
        elif word in _OTHERS and not (word == "socket" and following in _HEADS):
            said = "other"
        elif word in _SUPPORTING:
            said = "plug"
        else:
            said = next((kind for ending, kind in ENDINGS.items() if word.endswith(ending)), said)
    return said
