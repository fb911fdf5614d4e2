"""SQL by the server's own client library: faster than a psql for each statement, of which a test has dozens."""

import ctypes

LIBRARY = ctypes.CDLL("libpq.so.5")
for name, result in (("PQconnectdb", ctypes.c_void_p), ("PQexec", ctypes.c_void_p), ("PQerrorMessage", ctypes.c_char_p),
                     ("PQgetvalue", ctypes.c_char_p)):
    getattr(LIBRARY, name).restype = result
LIBRARY.PQsetNoticeProcessor.argtypes = [ctypes.c_void_p] * 3
NOT_TOLD = ctypes.CFUNCTYPE(None, ctypes.c_void_p, ctypes.c_char_p)(lambda *_: None)  # notices: what a DROP takes along
OK = (0, 1, 2)  # PQresultStatus: an empty text, a command that is done, rows


class Refused(Exception):
    """What the server says."""


def ask(conninfo, text):
    """The rows of the last statement as lists of text, NULL as nothing. All statements are one transaction."""
    link = ctypes.c_void_p(LIBRARY.PQconnectdb(conninfo.encode()))
    result = None
    try:
        if LIBRARY.PQstatus(link) != 0:
            raise Refused(LIBRARY.PQerrorMessage(link).decode())
        LIBRARY.PQsetNoticeProcessor(link, NOT_TOLD, None)
        result = ctypes.c_void_p(LIBRARY.PQexec(link, text.encode()))
        if LIBRARY.PQresultStatus(result) not in OK:
            raise Refused(LIBRARY.PQerrorMessage(link).decode())
        columns = range(LIBRARY.PQnfields(result))
        return [[LIBRARY.PQgetvalue(result, row, column).decode() for column in columns]
                for row in range(LIBRARY.PQntuples(result))]
    finally:
        LIBRARY.PQclear(result)
        LIBRARY.PQfinish(link)
