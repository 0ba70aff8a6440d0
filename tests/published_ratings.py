"""Factors and ratings that makers publish of the bearings of the catalogue; its rows have ranges of other makers."""

from typing import NamedTuple


class Published(NamedTuple):
    """Factor f0 of ISO 76, and the basic dynamic and static rating [kN]."""

    factor: float
    dynamic: float
    static: float


FACTORS = {  # NSK, Rolling Bearings, CAT. No. E1102; JTEKT (Koyo), CAT. NO. B2001RUS; 6000 to 6320
    "6000": (Published(12.4, 4.55, 1.97), Published(12.3, 4.55, 1.95)),
    "6001": (Published(13, 5.1, 2.37), Published(13.2, 5.1, 2.4)),
    "6002": (Published(13.9, 5.6, 2.83), Published(13.9, 5.6, 2.85)),
    "6003": (Published(14.4, 6, 3.25), Published(14.4, 6, 3.25)),
    "6004": (Published(13.8, 9.4, 5), Published(13.9, 9.4, 5.05)),
    "6005": (Published(14.5, 10.1, 5.85), Published(14.5, 10.1, 5.85)),
    "6006": (Published(14.7, 13.2, 8.3), Published(14.7, 13.2, 8.25)),
    "6007": (Published(14.8, 16, 10.3), Published(14.9, 15.9, 10.3)),
    "6008": (Published(15.3, 16.8, 11.5), Published(15.2, 16.7, 11.5)),
    "6009": (Published(15.3, 20.9, 15.2), Published(15.3, 21, 15.1)),
    "6010": (Published(15.6, 21.8, 16.6), Published(15.6, 21.8, 16.6)),
    "6011": (Published(15.3, 28.3, 21.2), Published(15.3, 28.3, 21.2)),
    "6012": (Published(15.6, 29.5, 23.2), Published(15.6, 29.4, 23.2)),
    "6013": (Published(15.8, 30.5, 25.2), Published(15.8, 30.5, 25.2)),
    "6014": (Published(15.6, 38, 31), Published(15.6, 38.1, 30.9)),
    "6015": (Published(15.8, 39.5, 33.5), Published(15.8, 39.6, 33.5)),
    "6016": (Published(15.6, 47.5, 40), Published(15.6, 47.6, 39.8)),
    "6017": (Published(15.8, 49.5, 43), Published(15.8, 49.5, 43.1)),
    "6018": (Published(15.6, 58, 50), Published(15.6, 58.2, 49.7)),
    "6019": (Published(15.8, 60.5, 54), Published(15.8, 60.4, 53.9)),
    "6020": (Published(15.9, 60, 54), Published(15.9, 60.2, 54.2)),
    "6200": (Published(13.2, 5.1, 2.39), Published(13.2, 5.1, 2.4)),
    "6201": (Published(12.3, 6.8, 3.05), Published(12.3, 6.8, 3.05)),
    "6202": (Published(13.2, 7.65, 3.75), Published(13.2, 7.65, 3.75)),
    "6203": (Published(13.2, 9.55, 4.8), Published(13.2, 9.55, 4.8)),
    "6204": (Published(13.1, 12.8, 6.6), Published(13.2, 12.8, 6.65)),
    "6205": (Published(13.9, 14, 7.85), Published(13.9, 14, 7.85)),
    "6206": (Published(13.8, 19.5, 11.3), Published(13.9, 19.5, 11.3)),
    "6207": (Published(13.8, 25.7, 15.3), Published(13.9, 25.7, 15.4)),
    "6208": (Published(14, 29.1, 17.9), Published(14, 29.1, 17.8)),
    "6209": (Published(14.4, 31.5, 20.4), Published(14, 32.7, 20.3)),
    "6210": (Published(14.4, 35, 23.2), Published(14.4, 35.1, 23.3)),
    "6211": (Published(14.3, 43.5, 29.3), Published(14.4, 43.4, 29.4)),
    "6212": (Published(14.3, 52.5, 36), Published(14.4, 52.4, 36.2)),
    "6213": (Published(14.4, 57.5, 40), Published(14.4, 57.2, 40.1)),
    "6214": (Published(14.5, 62, 44), Published(14.5, 62.2, 44.1)),
    "6215": (Published(14.7, 66, 49.5), Published(14.5, 67.4, 48.3)),
    "6216": (Published(14.6, 72.5, 53), Published(14.6, 72.7, 53)),
    "6217": (Published(14.5, 84, 62), Published(14.5, 84, 61.9)),
    "6218": (Published(14.5, 96, 71.5), Published(14.5, 96.1, 71.5)),
    "6219": (Published(14.4, 109, 82), Published(14.4, 109, 81.9)),
    "6220": (Published(14.4, 122, 93), Published(14.4, 122, 93.1)),
    "6300": (Published(11.2, 8.1, 3.45), Published(11.2, 8.1, 3.45)),
    "6301": (Published(11.1, 9.7, 4.2), Published(11.1, 9.7, 4.2)),
    "6302": (Published(12.3, 11.4, 5.45), Published(12.3, 11.4, 5.45)),
    "6303": (Published(12.4, 13.6, 6.65), Published(12.4, 13.6, 6.65)),
    "6304": (Published(12.4, 15.9, 7.9), Published(12.3, 15.9, 7.85)),
    "6305": (Published(13.2, 20.6, 11.2), Published(13.2, 20.6, 11.3)),
    "6306": (Published(13.3, 26.7, 15), Published(13.3, 26.7, 15)),
    "6307": (Published(13.2, 33.5, 19.2), Published(13.2, 33.4, 19.3)),
    "6308": (Published(13.2, 40.5, 24), Published(13.2, 40.7, 24)),
    "6309": (Published(13.1, 53, 32), Published(13.3, 48.9, 29.5)),
    "6310": (Published(13.2, 62, 38.5), Published(13.2, 62, 38.3)),
    "6311": (Published(13.1, 71.5, 44.5), Published(13.2, 71.6, 45)),
    "6312": (Published(13.1, 82, 52), Published(13.2, 81.9, 52.2)),
    "6313": (Published(13.2, 92.5, 60), Published(13.2, 92.7, 59.9)),
    "6314": (Published(13.2, 104, 68), Published(13.2, 104, 68.2)),
    "6315": (Published(13.2, 113, 77), Published(13.2, 113, 77.2)),
    "6316": (Published(13.3, 123, 86.5), Published(13.3, 123, 86.7)),
    "6317": (Published(13.3, 133, 97), Published(13.3, 133, 96.8)),
    "6318": (Published(13.3, 143, 107), Published(13.3, 143, 107)),
    "6319": (Published(13.3, 153, 119), Published(13.3, 153, 119)),
    "6320": (Published(13.2, 173, 141), Published(13.2, 173, 141)),
}
SKF_6305, SKF_6306 = (
    Published(12, 23.4, 11.6),
    Published(13, 29.6, 16.0),
)  # general catalogue; it rounds f0 to whole numbers
# SKF, general catalogue: least and greatest dynamic and static rating [kN] of the designs BEP, BECBP and BEY or BECBY
ANGULAR = {
    "7203B": ((10.4, 11.1), (5.5, 6.1)),
    "7204B": ((13.3, 14.3), (7.65, 8.3)),
    "7205B": ((14.8, 15.6), (9.3, 10.2)),
    "7206B": ((22.5, 24.0), (14.3, 15.6)),
    "7207B": ((29.1, 31.0), (19.0, 20.8)),
    "7208B": ((34.5, 36.5), (24.0, 26.0)),
    "7209B": ((35.8, 38.0), (26.0, 28.5)),
    "7210B": ((37.7, 40.0), (28.5, 31.0)),
}
# ISO 76: f0 for D cos(a)/d_m = 0.10, 0.11 ... 0.35
F0 = (16.4, 16.1, 15.9, 15.6, 15.4, 15.2, 14.9, 14.7, 14.4, 14.2, 14.0, 13.7, 13.5)
F0 += (13.2, 13.0, 12.8, 12.5, 12.3, 12.1, 11.8, 11.6, 11.4, 11.2, 10.9, 10.7, 10.5)
# steps of 1/64 inch, beyond 3/4 inch of 1/32, and 12 mm [m]
SOLD_BALLS = sorted({k * 25.4e-3 / 64 for k in range(4, 49)} | {k * 25.4e-3 / 32 for k in range(24, 60)} | {12.0e-3})
# FBJ: limiting speeds [1/min] with grease and with oil of the series 60, 62 and 63, bores of 10 to 100 mm
LIMITING_SPEEDS = {
    ("60", "grease"): (
        30000, 26000, 22000, 19000, 17000, 15000, 12000, 10000, 9500, 8000, 8500, 7500, 6700, 6300, 6000,
        5600, 5300, 5000, 4800, 4500, 4300,
    ),
    ("60", "oil"): (
        36000, 32000, 28000, 24000, 20000, 18000, 15000, 13000, 12000, 11000, 10000, 9000, 8000, 7500, 7000,
        6700, 6300, 6000, 5600, 5300, 5000,
    ),
    ("62", "grease"): (
        24000, 22000, 19000, 17000, 15000, 12000, 10000, 9000, 8500, 7500, 7000, 6300, 6000, 5300, 5000, 4800,
        4500, 4300, 3800, 3600, 3400,
    ),
    ("62", "oil"): (
        30000, 28000, 24000, 20000, 18000, 15000, 13000, 11000, 10000, 9000, 8500, 7500, 7000, 6300, 6000,
        5600, 5300, 5000, 4500, 4300, 4000,
    ),
    ("63", "grease"): (
        20000, 19000, 17500, 16000, 13000, 11000, 9000, 8500, 7500, 6700, 6300, 5600, 5000, 4800, 4500, 4300,
        4000, 3800, 3600, 3100, 2800,
    ),
    ("63", "oil"): (
        26000, 24000, 22000, 19000, 16000, 14000, 11000, 10000, 9000, 8000, 7500, 6700, 6000, 5600, 5300,
        5000, 4800, 4500, 4300, 3600, 3400,
    ),
}  # fmt: skip
