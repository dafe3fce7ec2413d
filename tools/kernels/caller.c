/* Call a compiled kernel: `Entry(address, release, takes, gives, records, n_takes, n_gives)`, and
   then as a function. What it is handed is written into rows of eight bytes each, without asking
   anybody for types; it runs without the interpreter's lock; what it gives is read from another row.

   `takes` and `gives` are specifications, one sign after another:
     d f i u b n    float64, float32, int64, uint64, bool, None
     [ T N          C-contiguous array with N axes; T is NumPy's number of its type, as a letter
                    from A
     { R N          the same of records: R is a letter from A, the place in `records`
     ( ... )        tuple

   Handed anything else, the method `_unfit(args, kwargs)` is called, and if the kernel raises an
   error, `_failed(code, pickled)`; both are for derived classes to define. */

#define PY_SSIZE_T_CLEAN
#define Py_LIMITED_API 0x030B0000
#define NPY_NO_DEPRECATED_API NPY_1_25_API_VERSION
#define NPY_TARGET_VERSION NPY_1_25_API_VERSION
#include <Python.h>
#include <numpy/arrayobject.h>
#include <stdint.h>
#include <string.h>

typedef struct {
    PyObject_HEAD
    int32_t (*code)(const int64_t *, int64_t *);
    void (*release)(void *);
    PyObject *takes, *gives, *records; /* str as bytes, str as bytes, tuple of dtypes */
    PyObject **met;                    /* of each record, the other dtype that was last found alike */
    Py_ssize_t n_takes, n_gives;       /* slots */
} Entry;

static int fits_array(PyArrayObject *array, int axes) {
    return PyArray_NDIM(array) == axes && PyArray_IS_C_CONTIGUOUS(array) &&
           PyArray_ISALIGNED(array) && PyArray_ISNOTSWAPPED(array);
}

static int write_array(PyArrayObject *array, int64_t **at) {
    *(*at)++ = (int64_t)(intptr_t)PyArray_DATA(array);
    for (int k = 0; k < PyArray_NDIM(array); k++)
        *(*at)++ = PyArray_DIM(array, k);
    return 1;
}

/* Write a value into slots, and go on in the specification; 1, 0 if it does not fit, -1 error. */
static int pack(const Entry *self, const char **spec, PyObject *value, int64_t **at) {
    switch (*(*spec)++) {
    case '[': {
        int type = (*spec)[0] - 'A';
        int axes = (*spec)[1] - '0';
        *spec += 2;
        if (!PyArray_Check(value))
            return 0;
        PyArrayObject *array = (PyArrayObject *)value;
        if (!fits_array(array, axes) || !PyArray_EquivTypenums(PyArray_TYPE(array), type))
            return 0;
        return write_array(array, at);
    }
    case '{': {
        PyObject **met = self->met + ((*spec)[0] - 'A');
        PyObject *record = PyTuple_GetItem(self->records, (*spec)[0] - 'A');
        int axes = (*spec)[1] - '0';
        *spec += 2;
        if (!record || !PyArray_Check(value))
            return record ? 0 : -1;
        PyArrayObject *array = (PyArrayObject *)value;
        PyObject *of = (PyObject *)PyArray_DESCR(array);
        if (!fits_array(array, axes))
            return 0;
        if (of != record && of != *met) { /* to compare fields takes a microsecond */
            if (!PyArray_EquivTypes((PyArray_Descr *)of, (PyArray_Descr *)record))
                return 0;
            Py_IncRef(of);
            Py_DecRef(*met);
            *met = of;
        }
        return write_array(array, at);
    }
    case '(': {
        if (!PyTuple_Check(value))
            return 0;
        Py_ssize_t n = PyTuple_Size(value);
        for (Py_ssize_t k = 0; k < n; k++) {
            if (**spec == ')')
                return 0;
            int fits = pack(self, spec, PyTuple_GetItem(value, k), at);
            if (fits != 1)
                return fits;
        }
        return *(*spec)++ == ')';
    }
    case 'd': {
        if (!PyFloat_Check(value) && (!PyLong_Check(value) || PyBool_Check(value)) &&
            !PyArray_IsScalar(value, Integer))
            return 0;
        double number = PyFloat_AsDouble(value);
        if (number == -1.0 && PyErr_Occurred())
            return -1;
        memcpy((*at)++, &number, 8);
        return 1;
    }
    case 'f': {
        if (!PyArray_IsScalar(value, Float))
            return 0;
        double number = PyFloat_AsDouble(value);
        memcpy((*at)++, &number, 8);
        return 1;
    }
    case 'i': {
        if ((!PyLong_Check(value) || PyBool_Check(value)) && !PyArray_IsScalar(value, Integer))
            return 0;
        int overflow;
        PyObject *number = PyNumber_Index(value);
        if (!number)
            return -1;
        *(*at)++ = PyLong_AsLongLongAndOverflow(number, &overflow);
        Py_DecRef(number);
        return !overflow;
    }
    case 'b': {
        if (!PyBool_Check(value) && !PyArray_IsScalar(value, Bool))
            return 0;
        int truth = PyObject_IsTrue(value);
        *(*at)++ = truth;
        return truth < 0 ? -1 : 1;
    }
    }
    PyErr_SetString(PyExc_SystemError, "a specification of no known kind");
    return -1;
}

/* Read a value from slots. */
static PyObject *unpack(const Entry *self, const char **spec, const int64_t **at) {
    char kind = *(*spec)++;
    switch (kind) {
    case 'n':
        Py_IncRef(Py_None);
        return Py_None;
    case 'i':
        return PyLong_FromLongLong(*(*at)++);
    case 'u':
        return PyLong_FromUnsignedLongLong((unsigned long long)*(*at)++);
    case 'b':
        return PyBool_FromLong((long)(*(*at)++ & 1));
    case 'd': {
        double number;
        memcpy(&number, (*at)++, 8);
        return PyFloat_FromDouble(number);
    }
    case '[': {
        int type = (*spec)[0] - 'A', axes = (*spec)[1] - '0';
        *spec += 2;
        const void *data = (const void *)(intptr_t)*(*at)++;
        npy_intp shape[10];
        for (int k = 0; k < axes; k++)
            shape[k] = (npy_intp) * (*at)++;
        void *block = (void *)(intptr_t)*(*at)++;
        PyObject *array = PyArray_SimpleNew(axes, shape, type);
        if (array)
            memcpy(PyArray_DATA((PyArrayObject *)array), data,
                   (size_t)PyArray_NBYTES((PyArrayObject *)array));
        self->release(block);
        return array;
    }
    case '(': {
        PyObject *list = PyList_New(0);
        while (list && **spec != ')') {
            PyObject *part = unpack(self, spec, at);
            if (!part || PyList_Append(list, part) < 0) {
                Py_DecRef(list);
                list = NULL;
            }
            Py_DecRef(part);
        }
        ++*spec;
        PyObject *tuple = list ? PyList_AsTuple(list) : NULL;
        Py_DecRef(list);
        return tuple;
    }
    }
    PyErr_SetString(PyExc_SystemError, "a specification of no known kind");
    return NULL;
}

static PyObject *entry_call(PyObject *object, PyObject *args, PyObject *kwargs) {
    Entry *self = (Entry *)object;
    int64_t takes[self->n_takes], gives[self->n_gives];
    int64_t *to = takes;
    const char *spec = PyBytes_AsString(self->takes);
    int fits = kwargs == NULL || PyDict_Size(kwargs) == 0;
    if (fits)
        fits = pack(self, &spec, args, &to);
    if (fits < 0)
        return NULL;
    if (!fits)
        return PyObject_CallMethod(object, "_unfit", "OO", args, kwargs ? kwargs : Py_None);
    PyThreadState *state = PyEval_SaveThread();
    int32_t code = self->code(takes, gives);
    PyEval_RestoreThread(state);
    if (code == -2) { /* numba's way to say None */
        Py_IncRef(Py_None);
        return Py_None;
    }
    if (code != 0)
        return PyObject_CallMethod(object, "_failed", "iy#", (int)code,
                                   code > 0 ? (const char *)(intptr_t)gives[0] : "",
                                   code > 0 ? (Py_ssize_t)gives[1] : (Py_ssize_t)0);
    const int64_t *from = gives;
    spec = PyBytes_AsString(self->gives);
    return unpack(self, &spec, &from);
}

static int entry_init(PyObject *object, PyObject *args, PyObject *kwargs) {
    static char *names[] = {"address", "release", "takes", "gives", "records", "n_takes", "n_gives", NULL};
    Entry *self = (Entry *)object;
    unsigned long long address, release;
    if (!PyArg_ParseTupleAndKeywords(args, kwargs, "KKSSO!nn", names, &address, &release,
                                     &self->takes, &self->gives, &PyTuple_Type, &self->records,
                                     &self->n_takes, &self->n_gives))
        return -1;
    self->code = (int32_t(*)(const int64_t *, int64_t *))(uintptr_t)address;
    self->release = (void (*)(void *))(uintptr_t)release;
    self->met = PyMem_Calloc((size_t)PyTuple_Size(self->records) + 1, sizeof(PyObject *));
    if (!self->met)
        return PyErr_NoMemory(), -1;
    Py_IncRef(self->takes); /* kernels live as long as the process does */
    Py_IncRef(self->gives);
    Py_IncRef(self->records);
    return 0;
}

static PyType_Slot entry_slots[] = {
    {Py_tp_doc, "A kernel of a shared library."},
    {Py_tp_call, entry_call},
    {Py_tp_init, entry_init},
    {Py_tp_new, PyType_GenericNew},
    {0, NULL},
};
static PyType_Spec entry_spec = {
    .name = "paint3d.core.machine_code.Entry",
    .basicsize = sizeof(Entry),
    .flags = Py_TPFLAGS_DEFAULT | Py_TPFLAGS_BASETYPE,
    .slots = entry_slots,
};

/* The kinds of processor that code is made for and that this one is, the best first. */
static PyObject *processors(PyObject *self, PyObject *nothing) {
    (void)self, (void)nothing;
#if defined(__x86_64__)
    __builtin_cpu_init(); /* what its operating system lets programs use */
    if (__builtin_cpu_supports("x86-64-v4"))
        return Py_BuildValue("(ssss)", "x86-64-v4", "x86-64-v3", "x86-64-v2", "x86-64");
    if (__builtin_cpu_supports("x86-64-v3"))
        return Py_BuildValue("(sss)", "x86-64-v3", "x86-64-v2", "x86-64");
    if (__builtin_cpu_supports("x86-64-v2"))
        return Py_BuildValue("(ss)", "x86-64-v2", "x86-64");
    return Py_BuildValue("(s)", "x86-64");
#elif defined(__aarch64__)
    return Py_BuildValue("(s)", "aarch64");
#else
#error "code is made for x86-64 and aarch64 only"
#endif
}

static PyMethodDef methods[] = {
    {"processors", processors, METH_NOARGS, "The kinds of processor that this one is."},
    {NULL, NULL, 0, NULL},
};
static struct PyModuleDef module_def = {
    PyModuleDef_HEAD_INIT, .m_name = "caller", .m_size = -1, .m_methods = methods,
};

PyMODINIT_FUNC PyInit_caller(void) {
    import_array();
    PyObject *module = PyModule_Create(&module_def);
    PyObject *type = PyType_FromSpec(&entry_spec);
    if (!module || !type || PyModule_AddObject(module, "Entry", type) < 0)
        return NULL;
    return module;
}
