"""A strategy as XML of BehaviorTree.CPP, version 4, e.g. for Groot.

Conditions and actions are custom nodes; their models, which Groot needs, are part of the file.
Source: behaviortree.dev, "The XML schema".
"""

from __future__ import annotations

from xml.etree.ElementTree import Element, SubElement, indent, tostring

from pickcli.strategy.node_types import NODE_TYPES, NodeKind, ParameterType
from pickcli.strategy.strategy_tree import Argument, Strategy, StrategyNode

BUILT_IN = {"Sequence", "Fallback", "RetryUntilSuccessful", "Inverter", "ForceSuccess"}
_NODE_NAMES = {type_.xml_name for type_ in NODE_TYPES.values()}  # a tree with such a name would be that node
PORTS = {"attempts": "num_attempts"}  # names of BehaviorTree.CPP's own ports


def strategy_xml(strategy: Strategy) -> str:
    """Convert a strategy to XML.

    Args:
        strategy: The strategy.

    Returns:
        The file's text.
    """
    tree_id = f"{strategy.name} tree" if strategy.name in _NODE_NAMES else strategy.name
    root = Element("root", {"BTCPP_format": "4", "main_tree_to_execute": tree_id})
    tree = SubElement(root, "BehaviorTree", {"ID": tree_id})
    _add(tree, strategy.root)
    models = SubElement(root, "TreeNodesModel")
    used = {node.name for node in strategy.root.walk()}
    for type_ in NODE_TYPES.values():
        if type_.name in used and type_.xml_name not in BUILT_IN:
            model = SubElement(models, type_.kind.capitalize(), {"ID": type_.xml_name})
            for name, parameter in type_.parameters.items():
                kind = "int" if parameter.type is ParameterType.COUNT else "std::string"
                kind = "double" if parameter.type is ParameterType.SECONDS else kind
                SubElement(model, "input_port", {"name": name, "type": kind})
    indent(root)
    return '<?xml version="1.0" encoding="UTF-8"?>\n' + tostring(root, encoding="unicode") + "\n"


def _add(parent: Element, node: StrategyNode) -> None:
    """Add the element of a node, with everything below it."""
    is_compact = node.type.kind in (NodeKind.CONTROL, NodeKind.DECORATOR)  # its tag is its name
    ports = {
        PORTS.get(name, name) if node.type.xml_name in BUILT_IN else name: _value(value)
        for name, value in node.arguments.items()
    }
    element = (
        SubElement(parent, node.type.xml_name, ports)
        if is_compact
        else SubElement(parent, node.type.kind.capitalize(), {"ID": node.type.xml_name, **ports})
    )
    for child in node.children:
        _add(element, child)


def _value(value: Argument) -> str:
    if isinstance(value, tuple):
        return ";".join(value)  # BehaviorTree.CPP's separator of lists
    return str(value)
