"""An importer of FMUs by ctypes: what a simulation program calls, for tests."""

import ctypes
import zipfile
from ctypes import CFUNCTYPE, byref, c_char_p, c_double, c_int, c_size_t, c_uint, c_void_p
from xml.etree import ElementTree

LOGGER = CFUNCTYPE(None, c_void_p, c_char_p, c_int, c_char_p, c_char_p, c_char_p)


class Callbacks(ctypes.Structure):
    """Callbacks of FMI 2; memory is the FMU's own."""

    _fields_ = (("logger", LOGGER), ("memory", c_void_p * 3), ("environment", c_void_p))


class Library:
    """FMU of FMI 2 that was unpacked and loaded."""

    def __init__(self, path, folder):
        with zipfile.ZipFile(path) as archive:
            archive.extractall(folder)
        self.folder = folder
        root = ElementTree.parse(folder / "modelDescription.xml").getroot()
        self.token = root.get("guid")
        variables = root.findall("ModelVariables/ScalarVariable")
        self.references = {each.get("name"): int(each.get("valueReference")) for each in variables}
        self.whole = {each.get("name") for each in variables if each.find("Integer") is not None}
        [self.binary] = folder.glob("binaries/linux64/*.so")
        self.code = ctypes.CDLL(str(self.binary))
        self.code.fmi2Instantiate.restype = c_void_p
        self.told = []
        self.logger = LOGGER(lambda environment, name, status, category, form, text: self.told.append(text.decode()))
        self.callbacks = Callbacks(self.logger)

    def instance(self, start=0.0, **values):
        """An instance that is ready to step."""
        made = Instance(self)
        made.initialize(start, **values)
        return made


class Instance:
    """Instance of an FMU."""

    def __init__(self, library, token=None):
        self.library, self.time = library, 0.0
        token = (library.token if token is None else token).encode()
        self.component = c_void_p(
            library.code.fmi2Instantiate(b"one", c_int(1), token, b"", byref(library.callbacks), c_int(0), c_int(0))
        )

    def call(self, name, *arguments):
        return getattr(self.library.code, f"fmi2{name}")(self.component, *arguments)

    def initialize(self, start=0.0, **values):
        assert self.call("SetupExperiment", c_int(0), c_double(0.0), c_double(start), c_int(0), c_double(0.0)) == 0
        self.time = start
        for name, value in values.items():
            assert self.set(name.replace("__", "."), value) == 0
        assert self.call("EnterInitializationMode") == 0
        assert self.call("ExitInitializationMode") == 0

    def set(self, name, value):
        whole = name in self.library.whole
        reference, kind = c_uint(self.library.references[name]), c_int if whole else c_double
        return self.call("SetInteger" if whole else "SetReal", byref(reference), c_size_t(1), byref(kind(value)))

    def get(self, name):
        value, reference = c_double(), c_uint(self.library.references[name])
        assert self.call("GetReal", byref(reference), c_size_t(1), byref(value)) == 0
        return value.value

    def step(self, duration):
        status = self.call("DoStep", c_double(self.time), c_double(duration), c_int(1))
        self.time += duration
        return status

    def lifts(self, pulse, end, duration):
        """Lift at the end of each step, of a pulse from now on."""
        lifts, steps = [], round(end / duration)
        for i in range(steps):
            assert self.set("command", int(i * duration < pulse - 1e-9)) == 0
            assert self.step(duration) == 0
            lifts.append(self.get("lift_m"))
        return lifts

    def keep(self):
        state = c_void_p()
        assert self.call("GetFMUstate", byref(state)) == 0
        return state

    def restore(self, state, time):
        assert self.call("SetFMUstate", state) == 0
        self.time = time

    def drop(self, state):
        assert self.call("FreeFMUstate", byref(state)) == 0
        assert not state

    def serialized(self, state):
        size = c_size_t()
        assert self.call("SerializedFMUstateSize", state, byref(size)) == 0
        data = ctypes.create_string_buffer(size.value)
        assert self.call("SerializeFMUstate", state, data, size) == 0
        return data.raw

    def deserialized(self, data):
        state = c_void_p()
        status = self.call("DeSerializeFMUstate", data, c_size_t(len(data)), byref(state))
        return state if status == 0 else None

    def free(self):
        self.library.code.fmi2FreeInstance(self.component)
