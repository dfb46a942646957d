"""The stub lists the classes, members and parameters of the module."""

import ast
import inspect
import pathlib

import trephine._core as core

STUB = pathlib.Path(core.__file__).with_name("_core.pyi")


def members_of_stub():
    result = {}
    for node in ast.parse(STUB.read_text(encoding="utf-8")).body:
        if isinstance(node, ast.ClassDef):
            names = {}
            for item in node.body:
                if isinstance(item, ast.FunctionDef):
                    arguments = item.args
                    names[item.name] = [a.arg for a in arguments.args + arguments.kwonlyargs if a.arg != "self"]
                elif isinstance(item, ast.AnnAssign):
                    names[item.target.id] = []
                elif isinstance(item, ast.Assign):  # a value of an enumeration
                    names[item.targets[0].id] = item.value.value
            result[node.name] = names
    return result


def test_stub_has_the_members_of_the_module():
    stub = members_of_stub()
    classes = {name: value for name, value in vars(core).items() if inspect.isclass(value)}
    assert stub.keys() == classes.keys()
    for name, value in classes.items():
        if name == "Error":
            continue
        if name == "Fault":
            assert stub[name] == {bit.name: bit.value for bit in value}
            continue
        public = {member for member in vars(value) if not member.startswith("_")}
        assert public == {member for member in stub[name] if not member.startswith("_")}, name


def test_stub_has_the_parameters_of_the_module():
    for class_name, members in members_of_stub().items():
        for name, parameters in members.items():
            signature = (getattr(getattr(core, class_name), name, None).__doc__ or "").split("\n")[0]
            if "(" not in signature or "**" in signature:
                continue
            for parameter in parameters:
                assert f"{parameter}:" in signature, (class_name, name, parameter)
