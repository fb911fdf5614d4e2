"""SQL by the server's own client library: faster than a psql for each statement, of which a test has
dozens."""

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


class Session:
    """One connection. With it as with psql's -c: the statements of one text are one transaction."""

    def __init__(self, conninfo):
        self.link = ctypes.c_void_p(LIBRARY.PQconnectdb(conninfo.encode()))
        if LIBRARY.PQstatus(self.link) != 0:
            said = LIBRARY.PQerrorMessage(self.link).decode()
            self.__exit__()
            raise Refused(said)
        LIBRARY.PQsetNoticeProcessor(self.link, NOT_TOLD, None)

    def ask(self, text):
        """The rows of the last statement as lists of text, NULL as nothing."""
        result = ctypes.c_void_p(LIBRARY.PQexec(self.link, text.encode()))
        try:
            if LIBRARY.PQresultStatus(result) not in OK:
                raise Refused(LIBRARY.PQerrorMessage(self.link).decode())
            columns = range(LIBRARY.PQnfields(result))
            return [[LIBRARY.PQgetvalue(result, row, column).decode() for column in columns]
                    for row in range(LIBRARY.PQntuples(result))]
        finally:
            LIBRARY.PQclear(result)

    def __enter__(self):
        return self

    def __exit__(self, *_):
        LIBRARY.PQfinish(self.link)


def ask(conninfo, text):
    with Session(conninfo) as session:
        return session.ask(text)
