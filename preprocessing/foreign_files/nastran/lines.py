"""Lines of the bulk data section with included files in their place, names of cards, and numbers in their fields.

Numbers in the fields of cards, many fields at once: each is a whole number, a real number or blank, or it is wrong.

Nastran writes 1.5-7 for 1.5e-7, and D for E. Every field goes through the same states, character by character; what leads to no state is
wrong, so that no text is taken for a number by chance.
"""

from __future__ import annotations

import os
import re
from bisect import bisect
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import NamedTuple

import numpy as np

from preprocessing.foreign_files.child import LARGEST_FILE
from preprocessing.foreign_files.contents import included_file
from toolkit.foundation.errors import InputError
from toolkit.foundation.files.safe_files import read_whole

STATEMENT = re.compile(rb"[ \t]*include(?=[\s='\"]|$)[ \t]*=?", re.IGNORECASE)
ANY_STATEMENT = re.compile(rb"^[ \t]*include", re.IGNORECASE | re.MULTILINE)
BEGIN = re.compile(rb"[ \t]*begin\b[ \t]*(.*)", re.IGNORECASE)
CASE_PARAMETER = re.compile(rb"[ \t]*param[ \t]*[, \t]", re.IGNORECASE)
CASE_CONTROL = re.compile(rb"[ \t]*cend[ \t]*(\$.*)?", re.IGNORECASE)
DEEPEST_INCLUDE, MOST_FILES = 20, 1000
"""Files that include each other in a row, and files in all, that a bulk file is made of."""


@dataclass
class BulkLines:
    """Lines of several files after one another, and where each of them stands."""

    main: Path
    texts: list[bytes] = field(default_factory=list)
    pieces: list[tuple[int, Path, int]] = field(default_factory=list)  # first line here, file, its number there less one

    def add(self, texts: list[bytes], path: Path, before: int) -> None:
        """Append lines of a file that follow so many others there."""
        self.pieces.append((len(self.texts), path, before))
        self.texts.extend(texts)

    def place(self, line: int) -> str:
        """Position of a line, in words."""
        start, path, before = self.pieces[bisect([first for first, _, _ in self.pieces], line) - 1]
        return f"{str(path)!r}, line {before + line - start + 1}"

    def error(self, line: int, what: str) -> InputError:
        """Error saying that something is wrong with a line."""
        return InputError(f"{self.place(line)}: {what}")


def bulk_lines(path: Path) -> tuple[BulkLines, list[int]]:
    """All lines of a file and those that it includes, and which of them are bulk data; PARAM of case control counts as such.

    Raises
    ------
    InputError
        A file cannot be read, is no text, or includes itself; or the bulk data section is not to be found.
    """
    found = BulkLines(path)
    _append(path, found, (os.path.realpath(path),), [0])
    begins = [(k, match[1]) for k, line in enumerate(found.texts) if line[:1] in b" \tbB" and (match := BEGIN.match(line))]
    for k, rest in begins:
        if k != begins[0][0] or rest.partition(b"$")[0].split() not in ([], [b"BULK"], [b"bulk"], [b"Bulk"]):
            raise found.error(k, "BEGIN begins a superelement or another part, and one BEGIN BULK is read. Write one model.")
    start = begins[0][0] + 1 if begins else 0
    if not begins:
        for k, line in enumerate(found.texts):
            if CASE_CONTROL.fullmatch(line):
                raise found.error(k, "CEND is not followed by BEGIN BULK. Add that line ahead of the first card.")
    parameters = [k for k in range(start) if CASE_PARAMETER.match(found.texts[k])]
    return found, [*parameters, *range(start, len(found.texts))]


def _append(path: Path, found: BulkLines, chain: tuple[str, ...], count: list[int]) -> None:
    """Append the lines of a file, and of all that it includes."""
    count[0] += 1
    if len(chain) > DEEPEST_INCLUDE + 1 or count[0] > MOST_FILES:
        raise InputError(
            f"{str(found.main)!r} includes more than {MOST_FILES} files, or more than {DEEPEST_INCLUDE} in a row. Write the "
            "mesh in one file."
        )
    content, at = text_of(path), 0
    texts = content.splitlines()
    for first, after, name in statements(texts) if ANY_STATEMENT.search(content) else ():
        found.add(texts[at:first], path, at)
        named, at = included_file(found.main, path, name), after
        place = os.path.realpath(named) if "\0" not in name else name
        if place in chain:
            raise InputError(f"{str(path)!r} includes {str(named)!r}, which includes it in turn. Take one of the two lines out.")
        _append(named, found, (*chain, place), count)
    found.add(texts[at:], path, at)


def text_of(path: Path) -> bytes:
    """The content of a file, whose lines end as under Linux.

    Raises
    ------
    InputError
        It cannot be read, or is no text.
    """
    try:
        content = read_whole(path, LARGEST_FILE)
    except OSError as error:
        raise InputError(f"{str(path)!r} cannot be read ({error.strerror}). Fix the path, or give a regular file.") from error
    if b"\0" in content:
        raise InputError(f"{str(path)!r} is no bulk data: it holds zero bytes. Save it as plain text in ASCII or UTF-8.")
    content = content.removeprefix(b"\xef\xbb\xbf")
    return content.replace(b"\r\n", b"\n").replace(b"\r", b"\n") if b"\r" in content else content


def statements(texts: list[bytes]) -> Iterator[tuple[int, int, str]]:
    """Every INCLUDE: its first line, the line after its last one, and the name of the file, which quotes may spread over several lines."""
    after = 0
    for k, line in enumerate(texts):
        if k >= after and line[:1] in b" \tiI" and (match := STATEMENT.match(line)):
            name, after = _name(texts, k, line[match.end() :].strip())
            yield k, after, os.fsdecode(name).replace("\\", "/")  # files are named as under Windows, too


def _name(texts: list[bytes], k: int, rest: bytes) -> tuple[bytes, int]:
    """The name that begins with the rest of line k, and the line after its end."""
    quote = rest[:1]
    if quote not in (b"'", b'"'):
        return rest.partition(b"$")[0].strip(), k + 1
    name, end = rest[1:], k + 1
    while quote not in name and end < min(len(texts), k + DEEPEST_INCLUDE):
        name, end = name + texts[end].strip(), end + 1
    return (name.partition(quote)[0], end) if quote in name else (rest[1:].partition(b"$")[0].strip(), k + 1)


def named_files(main: Path, path: Path, content: bytes) -> Iterator[Path]:
    """The files that one of the files of a bulk file includes."""
    if ANY_STATEMENT.search(content.replace(b"\r", b"\n")):
        for _, _, name in statements(content.splitlines()):
            yield included_file(main, path, name)


BLANK, DIGIT, SIGN, POINT, LETTER, OTHER = range(6)
"""Classes of characters."""
START, SIGNED, WHOLE, POINT_FIRST, FRACTION, POWER_LETTER, POWER_SIGN, POWER, WHOLE_END, REAL_END, WRONG = range(11)
"""States: what stands to the left."""
STEPS = {
    START: {BLANK: START, DIGIT: WHOLE, SIGN: SIGNED, POINT: POINT_FIRST},
    SIGNED: {DIGIT: WHOLE, POINT: POINT_FIRST},
    WHOLE: {BLANK: WHOLE_END, DIGIT: WHOLE, POINT: FRACTION, LETTER: POWER_LETTER},
    POINT_FIRST: {DIGIT: FRACTION},
    FRACTION: {BLANK: REAL_END, DIGIT: FRACTION, SIGN: POWER_SIGN, LETTER: POWER_LETTER},
    POWER_LETTER: {DIGIT: POWER, SIGN: POWER_SIGN},
    POWER_SIGN: {DIGIT: POWER},
    POWER: {BLANK: REAL_END, DIGIT: POWER},
    WHOLE_END: {BLANK: WHOLE_END},
    REAL_END: {BLANK: REAL_END},
}
LONGEST_WHOLE = 18
"""Digits of the largest whole numbers that are sure to fit into 64 bits."""
EXACT_POWER, EXACT_WHOLE = 22, 2**53
"""Powers of ten and whole numbers up to these are exact, so that one product or quotient of them is the nearest number."""
TENS = np.array([float(10**k) for k in range(EXACT_POWER + 1)])


def _classes() -> np.ndarray:
    found = np.full(256, OTHER, np.uint8)
    for characters, of in ((b" ", BLANK), (b"0123456789", DIGIT), (b"+-", SIGN), (b".", POINT), (b"eEdD", LETTER)):
        found[list(characters)] = of
    return found


def _steps() -> np.ndarray:
    found = np.full((WRONG + 1, OTHER + 1), WRONG, np.uint8)
    for state, onward in STEPS.items():
        for character, following in onward.items():
            found[state, character] = following
    return found


CLASSES, NEXT = _classes(), _steps()


class FieldNumbers(NamedTuple):
    """Values of fields, all in one shape."""

    values: np.ndarray  # 0 where there is none
    blank: np.ndarray  # whether the field is
    wrong: np.ndarray  # whether it is neither blank nor such a number


class _Scan(NamedTuple):
    state: np.ndarray
    digits: np.ndarray  # all digits ahead of the exponent, as one whole number
    significant: np.ndarray  # how many there are, zeros at the front not among them
    power: np.ndarray  # of ten, by which they count
    negative: np.ndarray


def whole_numbers(text: np.ndarray) -> FieldNumbers:
    """Values (...) of fields (..., characters)."""
    scan = _scan(text)
    good = np.isin(scan.state, (WHOLE, WHOLE_END)) & (scan.significant <= LONGEST_WHOLE)
    blank = scan.state == START
    return FieldNumbers(np.where(good, np.where(scan.negative, -scan.digits, scan.digits), 0), blank, ~good & ~blank)


def real_numbers(text: np.ndarray) -> FieldNumbers:
    """Values (...) of fields (..., characters); a whole number is a real one, too."""
    scan = _scan(text)
    good, blank = np.isin(scan.state, (WHOLE, WHOLE_END, FRACTION, POWER, REAL_END)), scan.state == START
    exact = good & (scan.significant <= LONGEST_WHOLE) & (scan.digits <= EXACT_WHOLE) & (np.abs(scan.power) <= EXACT_POWER)
    digits, ten = np.where(exact, scan.digits, 0).astype(float), TENS[np.where(exact, np.abs(scan.power), 0)]
    values = np.where(scan.power < 0, digits / ten, digits * ten)
    values = np.where(scan.negative & exact, -values, values)
    for place in zip(*np.nonzero(good & ~exact), strict=True):
        values[place] = one_number(text[place].tobytes().decode("ascii"))
    finite = np.isfinite(values)
    return FieldNumbers(np.where(finite, values, 0), blank, (~good & ~blank) | ~finite)


def one_number(text: str) -> float:
    """The value of the text of a real number, whatever its size."""
    return float(re.sub(r"(?<=[0-9.])([+-])", r"E\1", text.upper().strip().replace("D", "E")))


def _scan(text: np.ndarray) -> _Scan:
    """Go through all fields at once, from left to right."""
    shape = text.shape[:-1]
    state, negative, down = np.zeros(shape, np.uint8), np.zeros(shape, bool), np.zeros(shape, bool)
    digits, significant, places, power = (np.zeros(shape, np.int64) for _ in range(4))
    for character in np.ascontiguousarray(np.moveaxis(text, -1, 0)):
        kind = CLASSES[character]
        state = NEXT[state, kind]
        number, value, minus = kind == DIGIT, character - np.uint8(ord("0")), character == ord("-")
        ahead, behind = number & (state <= FRACTION), number & (state == POWER)
        digits = np.where(ahead, 10 * digits + value, digits)
        significant += ahead & ((significant > 0) | (value > 0))
        places += ahead & (state == FRACTION)
        negative |= minus & (state == SIGNED)
        if behind.any():
            power = np.where(behind, np.minimum(10 * power + value, 100_000), power)
        down |= minus & (state == POWER_SIGN)
    return _Scan(state, digits, significant, np.where(down, -power, power) - places, negative)


SOLIDS = {
    "CTETRA": {4: "tetra", 10: "tetra10"},
    "CHEXA": {8: "hexahedron", 20: "hexahedron20"},
    "CPENTA": {6: "wedge", 15: "wedge15"},
}
"""Card -> number of nodes -> kind of element in the words of meshio."""
SHELLS = {
    **{name: {4: "quad"} for name in ("CQUAD4", "CQUADR", "CPLSTN4", "CPLSTS4")},
    **{name: {8: "quad8"} for name in ("CQUAD8", "CPLSTN8", "CPLSTS8")},
    **{name: {3: "triangle"} for name in ("CTRIA3", "CTRIAR", "CPLSTN3", "CPLSTS3")},
    **{name: {6: "triangle6"} for name in ("CTRIA6", "CPLSTN6", "CPLSTS6")},
}
"""Those of a plane body; beside solids they carry mass and stiffness, unless their property is not in the file and they only name faces."""
RODS = {name: {2: "line"} for name in ("CBAR", "CBEAM", "CROD", "CTUBE")}
"""The same of lines, which no body has."""
SHELL_PROPERTIES = ("PSHELL", "PCOMP", "PCOMPG", "PCOMPP", "PLPLANE", "PPLANE", "PCOMPF")
ROD_PROPERTIES = ("PBAR", "PBARL", "PBEAM", "PBEAML", "PBCOMP", "PBMSECT", "PBRSECT", "PROD", "PTUBE", "PBEND")
SYSTEMS = ("CORD1R", "CORD1C", "CORD1S", "CORD2R", "CORD2C", "CORD2S")
TAKEN = {*SOLIDS, *SHELLS, *RODS, *SYSTEMS, "GRID", "GRDSET", "CONM1", "CONM2", "SET1", "SET3", "PSOLID", "MAT1", "PARAM"}
"""Cards that are read."""

_CARRYING = """
    CAABSF CBARR CBEAM3 CBEAR CBELT CBEND CBUSH CBUSH1D CBUSH2D CBUSHT CCONEAX CDAMP1 CDAMP2 CDAMP3 CDAMP4 CDAMP5 CDUM1 CDUM2 CDUM3
    CDUM4 CDUM5 CDUM6 CDUM7 CDUM8 CDUM9 CELAS1 CELAS2 CELAS3 CELAS4 CFAST CFILLET CFLUID2 CFLUID3 CFLUID4 CGAP CGAPG CHACAB CHACBR
    CHEX20 CHEX8 CHEXA1 CHEXA2 CHEXAL CHEXCZ CHEXP CIFHEX CIFPENT CIFQDX CIFQUAD CIHEX1 CIHEX2 CIHEX3 CINTC CJOINT CMASS1 CMASS2 CMASS3
    CMASS4 CMFREE CONROD CPENP CPENTCZ CPIPE CPYR CPYRA CPYRAM CQDMEM CQDMEM1 CQDMEM2 CQDPLT CQUAD CQUAD1 CQUAD9 CQUAD2 CQUADP CQUADX
    CQUADX4 CQUADX8 CRAC2D CRAC3D CSEAM CSHEAR CSLOT3 CSLOT4 CSUPER CSUPEXT CTETP CTETRA10 CTETRA4 CTORDRG CTRAPAX CTRAPRG CTRAX3 CTRAX6
    CTRBSC CTRIA1 CTRIA2 CTRIAAX CTRIAP CTRIARG CTRIAX CTRIAX6 CTRIM6 CTRMEM CTRPLT CTRPLT1 CTRSHL CTWIST CVISC CWEDGE CWELD CYJOIN
    DMIAX DMIG DMIGOUT DMIGROT GENEL K2GG M2GG MFLUID NSM NSM1 NSMADD NSML NSML1 NSMLS NSMLS1 NSMS NSMS1 TF
"""
CARRYING = frozenset(_CARRYING.split())
"""Cards that carry mass or stiffness, or are geometry, and are not taken."""

TOLD = {
    "ties between nodes are interface_points of body.toml": """
        RBE1 RBE2 RBE3 RBAR RBAR1 RROD RTRPLT RTRPLT1 RSPLINE RSSCON RJOINT RBE2GS MPC MPCADD MPCAX MPCY BGSET BGADD BGPARM BCTSET
        BCTADD BCTPARM BCTPARA BCTABLE BCTABL1 BCBODY BCBODY1 BCONP BSURF BSURFS BCPROP BCPROPS BLSEG BCONECT BCONTACT BCPARA
        BCRPARA BFRIC BCBDPRP BCGRID BCHANGE BCMOVE BCONPRG BCONPRP BCONUDS BCPFLG BCSEG BCRGSRF BCRIGID BCPATCH BCBZIER BCNURB2
        BCNURBS BCSURF BCSCAP BCTRIM BCELIPS BCNDPRP BCTPAR2 BCAUTOP CONTACT TIE""",
    "constraints are the clamp of body.toml": """
        SPC SPC1 SPCADD SPCD SPCR SPCAX SPCOFF SPCOFF1 SUPORT SUPORT1 SUPAX SESUP""",
    "loads are those of a scene": """
        FORCE FORCE1 FORCE2 FORCEAX MOMENT MOMENT1 MOMENT2 MOMAX PLOAD PLOAD1 PLOAD2 PLOAD4 PLOADX PLOADX1 PLOADE1 PLOADB3 PRESAX
        PRESPT GRAV ACCEL ACCEL1 RFORCE RFORCE1 LOAD LOADT CLOAD SLOAD LOADCYH LOADCYN LOADCYT DLOAD RLOAD1 RLOAD2 TLOAD1 TLOAD2
        ACSRCE LSEQ DAREA DELAY DPHASE DEFORM TEMP TEMPD TEMPP1 TEMPP2 TEMPP3 TEMPRB TEMPB3 TEMPBC TEMPAX TEMPF TEMPG TEMPP TEMPEX
        TEMPADD SELOAD BOLT BOLTFOR BOLTLD BOLTSEQ BOLTFRC PRETENS QBDY1 QBDY2 QBDY3 QHBDY QVECT QVOL GUST SPOINTL UNBALNC IC TIC
        TICD PFORCE ACLOAD""",
    "points without a place carry no part of the body": """
        SPOINT EPOINT""",
    "its nodes and elements are no group, as those of SET1 and SET3 are": """
        SET SET2 SET4""",
    "lines and faces of plots carry nothing": """
        PLOTEL PLOTEL3 PLOTEL4 PLOTEL6 PLOTEL8 PLOTTET PLOTHEX PLOTPEN PLOTPYR CBARAO""",
}
"""Why -> names of cards that are no part of the body, of which the user hears."""
WHY = {name: why for why, names in TOLD.items() for name in names.split()}

_OTHERS = """
    ACFPM ACMODL ACPEMCP AECOMP AECOMPL AEDW AEFACT AEFORCE AEGRID AELINK AELIST AELISTC AEPARM AEPRESS AEQUAD4 AERO AEROS AESCALE
    AESTAT AESURF AESURFS AETRIA3 AMLREG ASET ASET1 BAROR BARRIER BEAMOR BNDFIX BNDFIX1 BNDFRE1 BNDFREE BNDGRID BNDRY BSET BSET1 CAERO1
    CAERO2 CAERO3 CAERO4 CAERO5 CAMPBLL CHBDYE CHBDYG CHBDYP CMSET CMSMETH CONV CONVM CORD3G CORD3R CRACK CREEP CRKDYN CSET CSET1 CSSCHD
    CYAX CYSUP CYSYM DAMPGBL DAMPING DCOMP DCONADD DCONSTR DCONSTR1 DDVAL DEQATN DESGLB DESVAR DGLOBAL DIVERG DLINK DLINK2 DMI DMIJ
    DMIJI DMIK DMNCON DOBJREF DOPTPRM DOPTPRMS DREPADD DREPORT DRESP1 DRESP2 DRESP3 DSCONS DSCREEN DSHAPE DSHUFFLE DSIZE DTABLE DTABLE2
    DTI DTPG DTPL DVBSHAP DVCREL1 DVCREL2 DVGEOM DVGRID DVMREL1 DVMREL2 DVPREL1 DVPREL2 DVSHAP DVTREL1 DYCHANGE DYPARAM DYTIMHS ECHOOFF
    ECHOON EIGB EIGC EIGP EIGR EIGRA EIGRL ERPPANL ERPPNL EVENT EXTRN FATDEF FATEVNT FATLOAD FATPARM FATSEQ FEEDGE FEFACE FLFACT FLUTTER
    FREQ FREQ1 FREQ2 FREQ3 FREQ4 FREQ5 FTGDEF FTGEVNT FTGLOAD FTGPARM FTGSEQ GEOMCHEC GMBC GMBNDC GMBNDS GMCONV GMCORD GMCURV GMINTC
    GMINTS GMLOAD GMNURB GMSPC GMSURF GROUP HYBDAMP LABEL MAERO MAT10 MAT11 MAT12 MAT1F MAT2 MAT2F MAT3 MAT3D MAT4 MAT5 MAT8 MAT8F MAT9
    MAT9F MATCID MATCR MATCRP MATCZ MATDIGI MATDMG MATEP MATF MATF1 MATFAT MATG MATHE MATHED MATHEM MATHFLD MATHP MATM MATNLE MATNLE1
    MATORT MATOVR MATPE1 MATPOR MATRIG MATS1 MATS3 MATS8 MATSMA MATSORT MATSR MATT1 MATT11 MATT2 MATT3 MATT4 MATT5 MATT8 MATT9 MATTC
    MATTEP MATTF MATTG MATTHE MATTM MATTORT MATTUSR MATTVE MATTVP MATUDS MATUSR MATVE MATVP MATVPF MATX MDLPRM MICPNT MKAERO1 MKAERO2
    MODTRAK MONCNCM MONDSP1 MONGRP MONPNT1 MONPNT2 MONPNT3 MONSUM MONSUM1 MONSUMT NASTRAN NLADAPT NLAUTO NLCNTL NLCNTL2 NLCNTLG NLFREQ
    NLHARM NLMON NLOUT NLPARM NLPARMA NLPCI NLRGAP NLRSFD NLSTEP NLSTRAT NOLIN1 NOLIN2 NOLIN3 NOLIN4 NOLIN5 NOLIN6 NXSTRAT OMIT OMIT1
    OPTIM OUTPUT OUTRCV PAABSF PACABS PACBAR PAERO1 PAERO2 PAERO3 PAERO4 PAERO5 PANEL PBAR PBARL PBARN1 PBCOMP PBEAM PBEAM3 PBEAML
    PBEARS PBELT PBEMN1 PBEND PBMSECT PBRSECT PBSPOT PBUSH PBUSH1D PBUSH2D PBUSHT PCOHE PCOMP PCOMPF PCOMPG PCOMPLS PCOMPP PCOMPS
    PCONEAX PCONT PCONV PCONVM PDAMP PDAMP5 PDAMPT PELAS PELAST PFAST PFAST1 PFAT PFBODY PGAP PGPLSN PHBDY PIHEX PINTC PINTS PLOT
    PLOTOPT PLPLANE PLSOLID PMASS POINT PPLANE PPLSTN PPLSTS PQUAD1 PRAC2D PRAC3D PROD PRODN1 PSEAM PSET PSHEAR PSHEARN PSHELL PSHELL1
    PSHELLD PSHLN1 PSHLN2 PSLDN1 PSOLCZ PSOLD PSOLIDX PTRSHL PTUBE PTWIST PVAL PVISC PWELD QSET QSET1 RADBC RADC RADCAV RADCT RADLST
    RADM RADMAT RADMT RADMTX RADSET RADT RANDPS RANDT1 RELEASE RGYRO ROTORAX ROTORD ROTORG ROTORSE RSPINR RSPINT SEACMODL SEBNDRY SEBSET
    SEBSET1 SEBULK SECONCT SECSET SECSET1 SEDLINK SEDRSP2 SEDRSP3 SEELT SEEXCLD SEEXP SELABEL SELOC SEMPLN SENQSET SEQGP SEQSEP SEQSET
    SEQSET1 SESET SETREE SEUSET SEUSET1 SNORM SPBLND1 SPBLND2 SPLINE1 SPLINE2 SPLINE3 SPLINE4 SPLINE5 SPLINE6 SPLINE7
    SPLINEM SPLINEX SPLINRB STEP STEPS SUBTITLE SWLDPRM TABDMP1 TABFAT TABL3D TABL3D0 TABLE3D TABLEC1 TABLED TABLED1 TABLED2 TABLED3
    TABLED4 TABLED5 TABLED6 TABLED7 TABLEH1 TABLEHT TABLEL1 TABLEM1 TABLEM2 TABLEM3 TABLEM4 TABLEMD TABLES1 TABLES2 TABLEST TABLFAT
    TABLFTG TABLHT TABLXY TABRND TABRND1 TABRNDG TABSCTL TABVE TEMPBCD TIMNAT TIMNVH TITLE TOMVAR TOPVAR TRIM TRIM2 TRMC TSTEP TSTEP1
    TSTEPNL UDNAME UDSESV UNBAL UNITS USET USET1 USRSUB UXVEC VCCT VIEW VIEW3D
"""
OTHERS = frozenset(_OTHERS.split())
"""What is no part of the geometry, mass and stiffness of solids, and of which nothing is said: properties, materials, tables, control."""
