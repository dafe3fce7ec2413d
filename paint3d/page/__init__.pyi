from .folder import PageObject as PageObject
from .folder import build_page as build_page
